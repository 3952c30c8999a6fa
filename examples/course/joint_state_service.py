#!/usr/bin/env python3
# From the chapter "Week 5 - ROS 2 Services and Actions", its "Python Service Server".
#
# What had to change, and why:
#   1. Indentation: the chapter lost all of it in print.
#   2. The import of `Trigger`, which is not used, is left out.
# Nothing else. What looks odd but runs is left alone: `warn` is the logger's old name for `warning`, and
# Ctrl-C ends the program with KeyboardInterrupt out of rclpy.spin.
"""
ROS 2 Service Server for Joint State Queries
"""

import rclpy
from humanoid_interfaces.srv import GetJointState
from rclpy.node import Node


class JointStateService(Node):
    def __init__(self):
        super().__init__('joint_state_service')

        # Simulated joint states (in real system, read from hardware)
        self.joint_states = {
            'left_arm_shoulder': {'position': 0.5, 'velocity': 0.0, 'effort': 0.0},
            'right_arm_shoulder': {'position': -0.5, 'velocity': 0.0, 'effort': 0.0},
            'left_knee': {'position': 0.0, 'velocity': 0.0, 'effort': 0.0},
            'right_knee': {'position': 0.0, 'velocity': 0.0, 'effort': 0.0},
        }

        # Create service
        self.service = self.create_service(
            GetJointState, 'get_joint_state', self.get_joint_state_callback)

        self.get_logger().info('Joint State Service ready')

    def get_joint_state_callback(self, request, response):
        """Handle joint state queries"""
        joint_name = request.joint_name

        if joint_name in self.joint_states:
            state = self.joint_states[joint_name]
            response.position = state['position']
            response.velocity = state['velocity']
            response.effort = state['effort']
            response.is_moving = abs(state['velocity']) > 0.01
            self.get_logger().info(f'Served joint state for: {joint_name}')
        else:
            self.get_logger().warn(f'Unknown joint: {joint_name}')
            response.position = 0.0
            response.velocity = 0.0
            response.effort = 0.0
            response.is_moving = False

        return response

def main(args=None):
    rclpy.init(args=args)
    node = JointStateService()
    rclpy.spin(node)
    node.destroy_node()
    rclpy.shutdown()

if __name__ == '__main__':
    main()
