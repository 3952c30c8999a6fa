#!/usr/bin/env python3
# From the chapter "Week 5 - ROS 2 Services and Actions", its "Python Action Server".
#
# What had to change, and why:
#   1. Indentation: the chapter lost all of it in print.
#   2. `from rclpy.node import Node` was missing: the class statement raised NameError.
#   3. `import asyncio` was missing: `await asyncio.sleep(0.1)` raised NameError, which aborted every goal.
#   4. `goal_request` is not defined in execute_callback (it is the parameter of goal_callback); the request is
#      `goal_handle.request`. Twice: the target and the timeout.
# What looks wrong but runs is left alone: `rclpy.spin(node, executor=executor)` is rclpy's own form, the target's
# z is checked and then not driven to, a timeout of 0 divides by zero (which aborts that goal alone), and
# a cancelled goal's result has no final_pose.
# `await asyncio.sleep` in a callback runs under goalwire; ROS 2's own rclpy raises "no running event loop" there.
# `timeout` is not a limit here: the simulated drive always takes exactly that long.
# docs/explanation/topics-services-actions.md says how the humanoid's own server differs.
"""
ROS 2 Action Server for Robot Navigation
"""

import asyncio
import math
import time

import rclpy
from geometry_msgs.msg import PoseStamped
from humanoid_interfaces.action import MoveToPosition
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class NavigationActionServer(Node):
    def __init__(self):
        super().__init__('navigation_action_server')

        self._action_server = ActionServer(
            self,
            MoveToPosition,
            'move_to_position',
            execute_callback=self.execute_callback,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self.goal_callback,
            cancel_callback=self.cancel_callback)

        self.get_logger().info('Navigation Action Server ready')

    def goal_callback(self, goal_request):
        """Accept or reject goal requests"""
        # Validate goal
        if goal_request.target_pose.pose.position.z < 0:
            self.get_logger().warn('Rejected: Invalid target position')
            return GoalResponse.REJECT

        self.get_logger().info('Goal accepted')
        return GoalResponse.ACCEPT

    def cancel_callback(self, goal_handle):
        """Handle cancellation requests"""
        self.get_logger().info('Received cancel request')
        return CancelResponse.ACCEPT

    async def execute_callback(self, goal_handle):
        """Execute the navigation goal"""
        self.get_logger().info('Executing navigation goal')

        feedback_msg = MoveToPosition.Feedback()
        result = MoveToPosition.Result()

        # Simulated navigation
        start_time = time.time()
        target = goal_handle.request.target_pose.pose.position
        current_position = PoseStamped()
        current_position.pose.position.x = 0.0
        current_position.pose.position.y = 0.0
        current_position.pose.position.z = 0.0

        # Navigation loop
        while True:
            # Check for cancellation
            if goal_handle.is_cancel_requested:
                goal_handle.canceled()
                result.success = False
                result.message = 'Goal canceled'
                self.get_logger().info('Goal canceled')
                return result

            # Update current position (simulated)
            elapsed = time.time() - start_time
            progress = min(elapsed / goal_handle.request.timeout, 1.0)

            current_position.pose.position.x = target.x * progress
            current_position.pose.position.y = target.y * progress

            # Calculate distance remaining
            dx = target.x - current_position.pose.position.x
            dy = target.y - current_position.pose.position.y
            distance = math.sqrt(dx*dx + dy*dy)

            # Publish feedback
            feedback_msg.current_pose = current_position
            feedback_msg.elapsed_time = elapsed
            feedback_msg.distance_remaining = distance
            goal_handle.publish_feedback(feedback_msg)

            self.get_logger().debug(f'Progress: {progress*100:.1f}%')

            # Check completion
            if progress >= 1.0:
                break

            await asyncio.sleep(0.1)

        # Goal succeeded
        goal_handle.succeed()
        result.final_pose = current_position
        result.success = True
        result.message = 'Navigation completed successfully'

        self.get_logger().info('Navigation goal completed')
        return result

def main(args=None):
    rclpy.init(args=args)
    node = NavigationActionServer()

    executor = MultiThreadedExecutor()
    rclpy.spin(node, executor=executor)

    node.destroy_node()
    rclpy.shutdown()

if __name__ == '__main__':
    main()
