"""Publishes on one topic and hears another, under whichever rclpy and DDS runs it; says whom it has heard."""

from __future__ import annotations

import sys
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float64MultiArray, String

name, other = sys.argv[1:]
rclpy.init()
node = rclpy.create_node(name)
text = node.create_publisher(String, f'{name}/text', 10)
numbers = node.create_publisher(Float64MultiArray, f'{name}/numbers', 10)


def speak() -> None:
    text.publish(String(data=f'grüße von {name}'))
    numbers.publish(Float64MultiArray(data=[0.5, -1.25, 3e300]))


node.create_timer(0.05, speak)
node.create_subscription(String, f'{other}/text', lambda message: print('text', message.data, flush=True), 10)
node.create_subscription(
    Float64MultiArray,
    f'{other}/numbers',
    lambda message: print('numbers', list(message.data), flush=True),
    10,
)
node.create_timer(0.05, lambda: print('nodes', *sorted(node.get_node_names()), flush=True))
with suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
