"""Takes what floods.py sends, until it is killed."""

from __future__ import annotations

import rclpy
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('drinks')
count = 0


def drink(_message: String) -> None:
    global count  # noqa: PLW0603
    count += 1
    if count == 100:
        print('has had enough')


node.create_subscription(String, 'flood', drink, 10)
rclpy.spin(node)
