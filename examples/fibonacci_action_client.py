"""Sends a goal to the action `fibonacci` and follows it to its end. Other half: fibonacci_action_server.py.

python examples/fibonacci_action_client.py 8
python examples/fibonacci_action_client.py 8 --cancel-after 2     # seconds
"""

import argparse
import sys

import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.utilities import remove_ros_args

ENDINGS = {
    GoalStatus.STATUS_SUCCEEDED: 'succeeded',
    GoalStatus.STATUS_CANCELED: 'was cancelled',
    GoalStatus.STATUS_ABORTED: 'was aborted',
}


class FibonacciActionClient(Node):
    def __init__(self):
        super().__init__('fibonacci_action_client')
        self.client = ActionClient(self, Fibonacci, 'fibonacci')

    def run(self, order, cancel_after):
        """Send the goal and return how it ended: one of ENDINGS, or why it did not begin."""
        if not self.client.wait_for_server(timeout_sec=10.0):
            return 'found no server'
        sending = self.client.send_goal_async(Fibonacci.Goal(order=order), feedback_callback=self.show)
        rclpy.spin_until_future_complete(self, sending)
        goal = sending.result()
        if not goal.accepted:
            return 'was refused'
        if cancel_after is not None:
            self.create_timer(cancel_after, goal.cancel_goal_async)
        getting = goal.get_result_async()
        rclpy.spin_until_future_complete(self, getting)
        answer = getting.result()
        print(f'Result: {list(answer.result.sequence)}')
        return ENDINGS.get(answer.status, f'ended with status {answer.status}')

    def show(self, message):
        print(f'So far: {list(message.feedback.sequence)}')


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('order', type=int, help='how far to count')
    parser.add_argument('--cancel-after', type=float, metavar='SECONDS')
    options = parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    node = FibonacciActionClient()
    try:
        ending = node.run(options.order, options.cancel_after)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    print(f'The goal {ending}')
    sys.exit(0 if ending in ENDINGS.values() else 1)


if __name__ == '__main__':
    main()
