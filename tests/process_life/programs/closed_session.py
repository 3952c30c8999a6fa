"""After shutdown, a forked child keeps the files that have the numbers which the session had."""

from __future__ import annotations

import os

import rclpy
from forked import expect, in_child, is_open

rclpy.init()
node = rclpy.create_node('closed_session')
node.destroy_node()
rclpy.shutdown()
files = [os.open('/dev/null', os.O_RDONLY) for _ in range(64)]


def look() -> None:
    expect('lost in the child', [each for each in files if not is_open(each)], [])


expect('child', in_child(look), 0)
expect('lost in the parent', [each for each in files if not is_open(each)], [])
print('good')
