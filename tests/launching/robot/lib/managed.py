"""A managed node."""

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn


class Driver(LifecycleNode):
    def on_configure(self, state):
        self.get_logger().info('configured')
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.get_logger().info('activated')
        return super().on_activate(state)


try:
    with rclpy.init():
        rclpy.spin(Driver('managed'))
except (KeyboardInterrupt, ExternalShutdownException):
    pass
