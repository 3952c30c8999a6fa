"""Sends one goal to the end, cancels another half-way, has a third refused; prints what became of each."""

from typing import TypeVar

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.task import Future

T = TypeVar('T')


class FibonacciClient(Node):
    def __init__(self) -> None:
        super().__init__('fibonacci_client')
        self._client = ActionClient(self, Fibonacci, 'fibonacci')

    def wait_for_server(self) -> None:
        print('waiting')
        assert self._client.wait_for_server(timeout_sec=30.0)

    def spin_until(self, future: 'Future[T]') -> T:
        rclpy.spin_until_future_complete(self, future)
        result = future.result()
        assert result is not None
        return result

    def run_to_the_end(self) -> None:
        feedback: list[list[int]] = []
        goal = self.spin_until(
            self._client.send_goal_async(
                Fibonacci.Goal(order=6),
                feedback_callback=lambda message: feedback.append(list(message.feedback.sequence)),
            )
        )
        outcome = self.spin_until(goal.get_result_async())
        assert outcome.status == GoalStatus.STATUS_SUCCEEDED
        print(f'succeeded {list(outcome.result.sequence)} after {len(feedback)} feedback messages')

    def cancel_half_way(self) -> None:
        third: Future[int] = Future()
        numbers: list[int] = []

        def on_feedback(message: Fibonacci.Impl.FeedbackMessage) -> None:
            numbers.append(message.feedback.sequence[-1])
            if len(numbers) == 3:
                third.set_result(numbers[-1])

        goal = self.spin_until(
            self._client.send_goal_async(Fibonacci.Goal(order=10_000), feedback_callback=on_feedback)
        )
        self.spin_until(third)
        answer = self.spin_until(goal.cancel_goal_async())
        outcome = self.spin_until(goal.get_result_async())
        assert outcome.status == GoalStatus.STATUS_CANCELED
        print(
            f'canceled with return code {answer.return_code}, {len(answer.goals_canceling)} goal canceling, '
            f'{list(outcome.result.sequence[:5])}'
        )

    def be_refused(self) -> None:
        goal = self.spin_until(self._client.send_goal_async(Fibonacci.Goal(order=-1)))
        assert not goal.accepted
        print('refused')


def main() -> None:
    with rclpy.init():
        node = FibonacciClient()
        node.wait_for_server()
        node.run_to_the_end()
        node.cancel_half_way()
        node.be_refused()


if __name__ == '__main__':
    main()
