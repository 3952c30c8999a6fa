"""A program that guards nothing: what ends it shows."""

import rclpy

rclpy.init()
node = rclpy.create_node('bare')
print('ready')
rclpy.spin(node)
