"""Makes a node, or says in one line why it cannot."""

from __future__ import annotations

import rclpy

rclpy.init()
try:
    node = rclpy.create_node('opens')
    node.destroy_node()
except Exception as error:
    print(f'was refused: {type(error).__name__}: {error}')
rclpy.shutdown()
print('good')
