"""A node that does nothing."""

import rclpy
from rclpy.executors import ExternalShutdownException

try:
    with rclpy.init():
        node = rclpy.create_node('idle')
        print('ready')
        rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
print('stopped')
