"""Offers the action `fibonacci`: one number every half second. Its other half is fibonacci_action_client.py.

python examples/fibonacci_action_server.py

The goal's callback sleeps, so it holds a thread: with a MultiThreadedExecutor another one is free to hear a
cancel request. An `async def` callback that awaits asyncio.sleep() would do with one thread, but only on
goalwire: docs/tutorials/first-action.md.
"""

import time

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

STEP_S = 0.5
LARGEST_ORDER = 46  # the next number does not fit an int32


class FibonacciActionServer(Node):
    def __init__(self):
        super().__init__('fibonacci_action_server')
        self.server = ActionServer(
            self,
            Fibonacci,
            'fibonacci',
            self.execute,
            goal_callback=self.judge,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,  # noqa: ARG005
        )
        self.get_logger().info('Ready to count')

    def judge(self, request):
        return GoalResponse.ACCEPT if 0 < request.order <= LARGEST_ORDER else GoalResponse.REJECT

    def execute(self, goal):
        self.get_logger().info(f'Counting up to number {goal.request.order}')
        feedback = Fibonacci.Feedback(sequence=[0, 1])
        while len(feedback.sequence) <= goal.request.order:
            if goal.is_cancel_requested:
                goal.canceled()
                self.get_logger().info('Cancelled')
                return Fibonacci.Result(sequence=feedback.sequence)
            feedback.sequence.append(feedback.sequence[-1] + feedback.sequence[-2])
            goal.publish_feedback(feedback)
            time.sleep(STEP_S)
        goal.succeed()
        return Fibonacci.Result(sequence=feedback.sequence)


def main():
    rclpy.init()
    try:
        rclpy.spin(FibonacciActionServer(), executor=MultiThreadedExecutor())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
