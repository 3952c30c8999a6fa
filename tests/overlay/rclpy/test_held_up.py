"""A callback that holds up others is found, and one on which all others can well wait is not."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import cast

from example_interfaces.action import Fibonacci
from helpers.patience import soon, wait_for
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import SingleThreadedExecutor

from goalwire.execution.executors.spin_watch import Suspect, of_this_thread


def test_the_result_of_a_goal_can_wait_for_its_execution_and_cancelling_cannot(
    make_node: MakeNode, spin: Spin
) -> None:
    """The tutorials' server sleeps in its execute callback: nothing is wrong until somebody cancels."""
    node, other = make_node('server'), make_node('client')
    executor = cast('SingleThreadedExecutor', spin(node).executor)
    spin(other)
    begun, ended = Event(), Event()
    find: list[Callable[[], list[Suspect]]] = []

    def execute(goal_handle: ServerGoalHandle) -> Fibonacci.Result:
        find.append(of_this_thread(executor._ready, executor._timer_heap))
        begun.set()
        soon(ended)
        goal_handle.succeed()
        return Fibonacci.Result()

    server = ActionServer(node, Fibonacci, 'fibonacci', execute)
    client = ActionClient(other, Fibonacci, 'fibonacci')
    assert client.wait_for_server(10)
    goal = result_of(client.send_goal_async(Fibonacci.Goal()))
    assert soon(begun), 'execute was not called'
    result = goal.get_result_async()
    wait_for(lambda: executor._ready.items, 'the request for the result')
    assert find[0]() == []
    cancelling = goal.cancel_goal_async()
    wait_for(find[0], 'the request to cancel')
    ended.set()
    result_of(cancelling)
    result_of(result)
    server.destroy()
