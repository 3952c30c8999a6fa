"""A node that does nothing but hold the rendezvous."""

import rclpy
from rclpy.executors import ExternalShutdownException

try:
    with rclpy.init():
        node = rclpy.create_node('rendezvous')
        print('ready')
        rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
