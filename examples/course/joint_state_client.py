#!/usr/bin/env python3
# From the chapter "Week 5 - ROS 2 Services and Actions", its "Python Service Client".
#
# What had to change, and why:
#   1. Indentation: the chapter lost all of it in print.
# Nothing else. What runs but may surprise is left alone: without a server the constructor waits for ever,
# saying so once a second, and a response that never comes is waited for without limit.
"""
ROS 2 Service Client for Joint State Queries
"""

import rclpy
from humanoid_interfaces.srv import GetJointState
from rclpy.node import Node


class JointStateClient(Node):
    def __init__(self):
        super().__init__('joint_state_client')
        self.client = self.create_client(GetJointState, 'get_joint_state')

        while not self.client.wait_for_service(timeout_sec=1.0):
            self.get_logger().info('Service not available, waiting...')

    def send_request(self, joint_name):
        """Send joint state request"""
        request = GetJointState.Request()
        request.joint_name = joint_name

        future = self.client.call_async(request)
        rclpy.spin_until_future_complete(self, future)

        if future.result() is not None:
            response = future.result()
            self.get_logger().info(
                f'Joint: {joint_name}, '
                f'Position: {response.position:.3f}, '
                f'Velocity: {response.velocity:.3f}'
            )
            return response
        else:
            self.get_logger().error('Service call failed')
            return None

def main(args=None):
    rclpy.init(args=args)
    node = JointStateClient()

    # Query multiple joints
    joints = ['left_arm_shoulder', 'right_knee', 'left_knee']
    for joint in joints:
        node.send_request(joint)

    node.destroy_node()
    rclpy.shutdown()

if __name__ == '__main__':
    main()
