"""Logs from a node, in a folder of its own: no folder named ~ comes to be there."""

from __future__ import annotations

from pathlib import Path

import rclpy
from forked import expect

rclpy.init()
node = rclpy.create_node('homeless')
node.get_logger().info('hello')
expect('in the folder', list(Path().iterdir()), [])
node.destroy_node()
rclpy.shutdown()
print('good')
