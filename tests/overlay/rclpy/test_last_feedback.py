"""spin_until_future_complete leaves nothing behind that came before its future's end."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.context import Context
from rclpy.executors import Executor, MultiThreadedExecutor
from rclpy.task import Future

COUNT = 20


@pytest.mark.parametrize('late', [False, True], ids=['spinning before', 'spinning after'])
def test_a_burst_of_feedback_is_seen_before_the_result(
    make_node: MakeNode, spin: Spin, executor: Executor, late: bool
) -> None:
    go = threading.Event()

    def execute(handle: ServerGoalHandle) -> Any:
        assert go.wait(PATIENCE)
        for number in range(COUNT):
            handle.publish_feedback(Fibonacci.Feedback(sequence=[number]))
        handle.succeed()
        return Fibonacci.Result(sequence=[COUNT])

    server_node, client_node = make_node('server'), make_node('client')
    ActionServer(server_node, Fibonacci, 'count', execute)
    client = ActionClient(client_node, Fibonacci, 'count')
    assert client.wait_for_server(PATIENCE)
    spin(server_node)
    executor.add_node(client_node)
    seen: list[int] = []
    sending = client.send_goal_async(
        Fibonacci.Goal(order=1), lambda message: seen.extend(message.feedback.sequence)
    )
    executor.spin_until_future_complete(sending, PATIENCE)
    result = result_of(sending).get_result_async()
    go.set()
    if late:
        result_of(result)
    executor.spin_until_future_complete(result, PATIENCE)
    assert result.done()
    assert seen == list(range(COUNT))


def test_a_result_comes_while_a_callback_of_the_last_spin_still_runs(
    make_node: MakeNode, spin: Spin, context: Context
) -> None:
    """No feedback callback comes after that one, so nobody waits for them."""
    freed = threading.Event()
    begun: Future[None] = Future()

    def execute(handle: ServerGoalHandle) -> Any:
        handle.publish_feedback(Fibonacci.Feedback(sequence=[1]))
        handle.succeed()
        return Fibonacci.Result(sequence=[COUNT])

    def block() -> None:
        begun.set_result(None)
        assert freed.wait(PATIENCE)

    server_node, client_node = make_node('server'), make_node('client')
    ActionServer(server_node, Fibonacci, 'count', execute)
    client = ActionClient(client_node, Fibonacci, 'count')
    assert client.wait_for_server(PATIENCE)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(client_node)
    client_node.create_timer(0.001, block, MutuallyExclusiveCallbackGroup())
    try:
        executor.spin_until_future_complete(begun, PATIENCE)
        assert executor._pool.busy
        spin(server_node)
        handle = result_of(client.send_goal_async(Fibonacci.Goal(order=1), lambda _: None))
        assert result_of(handle.get_result_async()).result.sequence.tolist() == [COUNT]
    finally:
        freed.set()
        executor.shutdown()
