"""Publishes as fast as it can until asked to stop."""

import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('flood')
publisher = node.create_publisher(String, 'flood', 10)
message = String(data='x' * 100)
print('ready')
try:
    while rclpy.ok():
        publisher.publish(message)
except KeyboardInterrupt:
    print('stopped')
