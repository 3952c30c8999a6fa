"""Has many goals under way at once. Arguments: the first goal's number, how many goals."""

import sys
from collections import defaultdict
from functools import partial
from typing import Any

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future


class GatheringClient(Node):
    def __init__(self, first: int, number: int) -> None:
        super().__init__('gathering_client')
        self._client = ActionClient(self, Fibonacci, 'gather')
        self._goals = range(first, first + number)
        self.feedback: dict[int, list[int]] = defaultdict(list)
        self.results: dict[int, tuple[int, list[int]]] = {}
        self.finished: Future[None] = Future()

    def wait_for_server(self) -> None:
        assert self._client.wait_for_server(timeout_sec=20.0)

    def send_all(self) -> None:
        for order in self._goals:
            sent = self._client.send_goal_async(
                Fibonacci.Goal(order=order), partial(self._on_feedback, order)
            )
            sent.add_done_callback(partial(self._on_response, order))

    def _on_feedback(self, order: int, message: Fibonacci.Impl.FeedbackMessage) -> None:
        self.feedback[order].extend(message.feedback.sequence)

    def _on_response(self, order: int, sent: 'Future[ClientGoalHandle]') -> None:
        goal = sent.result()
        assert goal is not None
        assert goal.accepted
        goal.get_result_async().add_done_callback(partial(self._on_result, order))

    def _on_result(self, order: int, future: 'Future[Any]') -> None:
        outcome = future.result()
        assert outcome is not None
        self.results[order] = outcome.status, list(outcome.result.sequence)
        if len(self.results) == len(self._goals):
            self.finished.set_result(None)

    def check(self) -> None:
        assert self.results == {order: (GoalStatus.STATUS_SUCCEEDED, [order, 0]) for order in self._goals}
        assert self.feedback == {order: [order] for order in self._goals}
        print(f'{len(self.results)} right results')


def main(first: int, number: int) -> None:
    with rclpy.init():
        node = GatheringClient(first, number)
        node.wait_for_server()
        node.send_all()
        rclpy.spin_until_future_complete(node, node.finished)
        node.check()


if __name__ == '__main__':
    main(*map(int, sys.argv[1:]))
