"""Says when it sees the node that the argument names."""

from __future__ import annotations

import sys

import rclpy

me, other = sys.argv[1:]
rclpy.init()
node = rclpy.create_node(me)
print('ready', flush=True)
while other not in node.get_node_names():
    rclpy.spin_once(node, timeout_sec=0.05)
print('met', flush=True)
sys.stdin.readline()
node.destroy_node()
rclpy.shutdown()
