"""In which order an executor runs what is ready, with the server and the client of an action in it."""

from __future__ import annotations

from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.task import Future

pytestmark = pytest.mark.also_on_dds

Goal, Result, Feedback = Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback


class Pair:
    """A server and a client in one node, and what was seen, in order."""

    def __init__(self, node: Node) -> None:
        self.seen: list[str] = []
        self.sent: Future[Any] | None = None
        self.server = ActionServer(node, Fibonacci, 'fib', self.execute)
        self.client = ActionClient(node, Fibonacci, 'fib')
        assert self.client.wait_for_server(PATIENCE)

    def send(self) -> Future[Any]:
        self.sent = self.client.send_goal_async(Goal(order=1), lambda _: self.seen.append('feedback'))
        self.sent.add_done_callback(lambda _: self.seen.append('accepted'))
        return self.sent

    def execute(self, goal: Any) -> Fibonacci.Result:
        assert self.sent is not None
        self.seen.append('execution, and the future is done' if self.sent.done() else 'execution')
        goal.publish_feedback(Feedback(sequence=[1]))
        goal.succeed()
        return Result(sequence=[1])


@pytest.fixture(params=[SingleThreadedExecutor, EventsExecutor])
def single(request: pytest.FixtureRequest, make_node: MakeNode) -> Executor:
    executor: Executor = request.param(context=make_node('own').context)
    return executor


def test_an_execution_begins_before_the_future_of_its_goal_is_done(
    make_node: MakeNode, single: Executor
) -> None:
    node = make_node()
    pair = Pair(node)
    single.add_node(node)
    for _ in range(10):
        pair.seen.clear()
        sent = pair.send()
        single.spin_until_future_complete(sent, PATIENCE)
        assert sent.done()
        handle: Any = sent.result()
        single.spin_until_future_complete(handle.get_result_async(), PATIENCE)
        assert pair.seen[0] == 'execution'
        assert sorted(pair.seen[1:]) == ['accepted', 'feedback']


def test_the_feedback_of_an_execution_is_heard_before_the_spin_for_the_goal_returns(
    make_node: MakeNode, single: Executor
) -> None:
    node = make_node()
    heard: list[Any] = []
    pair = Pair(node)
    pair.sent = Future()
    node.create_subscription(Fibonacci.Impl.FeedbackMessage, 'fib/_action/feedback', heard.append, 10)
    plain = node.create_client(Fibonacci.Impl.SendGoalService, 'fib/_action/send_goal')
    assert plain.wait_for_service(PATIENCE)
    single.add_node(node)
    for number in range(10):
        request = Fibonacci.Impl.SendGoalService.Request()
        request.goal_id.uuid[0] = number
        single.spin_until_future_complete(plain.call_async(request), PATIENCE)
        assert len(heard) == number + 1


def test_a_callback_may_block_until_a_server_in_its_executor_accepts(
    make_node: MakeNode, executor: Any
) -> None:
    node = make_node()
    pair = Pair(node)
    ended: Future[Any] = Future()

    def drive() -> None:
        pair.sent = Future()
        timer.cancel()
        try:
            ended.set_result(pair.client.send_goal(Goal(order=1)))
        except RuntimeError as error:  # the only thread of the executor would wait for itself
            ended.set_result(error)

    timer = node.create_timer(0.001, drive)
    executor.add_node(node)
    executor.spin_until_future_complete(ended, PATIENCE)
    assert ended.done()
