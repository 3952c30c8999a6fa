#!/usr/bin/env python3
# From the chapter "Week 5 - ROS 2 Services and Actions", its "Python Action Client".
#
# What had to change, and why:
#   1. Indentation: the chapter lost all of it in print.
#   2. The import of `Pose`, which is not used, is left out.
# Nothing else. What runs but may surprise is left alone: wait_for_server waits for ever, and rclpy.spin goes on
# after the result, so that Ctrl-C ends the program.
"""
ROS 2 Action Client for Robot Navigation
"""

import rclpy
from geometry_msgs.msg import Point, Quaternion
from humanoid_interfaces.action import MoveToPosition
from rclpy.action import ActionClient
from rclpy.node import Node


class NavigationActionClient(Node):
    def __init__(self):
        super().__init__('navigation_action_client')
        self._action_client = ActionClient(
            self, MoveToPosition, 'move_to_position')

    def send_goal(self, x, y, z, timeout=30.0):
        """Send navigation goal"""
        self.get_logger().info('Waiting for action server...')
        self._action_client.wait_for_server()

        goal_msg = MoveToPosition.Goal()
        goal_msg.target_pose.pose.position = Point(x=x, y=y, z=z)
        goal_msg.target_pose.pose.orientation = Quaternion(w=1.0)
        goal_msg.timeout = timeout

        self.get_logger().info(f'Sending goal: ({x}, {y}, {z})')

        send_goal_future = self._action_client.send_goal_async(
            goal_msg, feedback_callback=self.feedback_callback)

        send_goal_future.add_done_callback(self.goal_response_callback)

    def goal_response_callback(self, future):
        """Handle goal response"""
        goal_handle = future.result()
        if not goal_handle.accepted:
            self.get_logger().error('Goal rejected')
            return

        self.get_logger().info('Goal accepted')

        get_result_future = goal_handle.get_result_async()
        get_result_future.add_done_callback(self.result_callback)

    def feedback_callback(self, feedback_msg):
        """Handle feedback"""
        feedback = feedback_msg.feedback
        self.get_logger().info(
            f'Feedback: Position=({feedback.current_pose.pose.position.x:.2f}, '
            f'{feedback.current_pose.pose.position.y:.2f}), '
            f'Distance={feedback.distance_remaining:.2f}m')

    def result_callback(self, future):
        """Handle result"""
        result = future.result().result
        self.get_logger().info(
            f'Result: Success={result.success}, Message={result.message}')

def main(args=None):
    rclpy.init(args=args)
    node = NavigationActionClient()
    node.send_goal(1.0, 2.0, 0.0, timeout=30.0)
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()

if __name__ == '__main__':
    main()
