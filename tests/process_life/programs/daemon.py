"""A daemon by double fork keeps the files that its first child has opened, while the session is open."""

from __future__ import annotations

import os

import rclpy
from forked import end_of, expect, is_open

rclpy.init()
node = rclpy.create_node('daemon')


def begin_daemon() -> int:
    os.setsid()
    files = [os.open('/dev/null', os.O_RDONLY) for _ in range(64)]
    daemon = os.fork()
    if daemon == 0:
        lost = [each for each in files if not is_open(each)]
        print(f'lost in the daemon: {lost}', flush=True)
        os._exit(1 if lost else 0)
    return 0 if end_of(daemon) == 0 else 1


child = os.fork()
if child == 0:
    os._exit(begin_daemon())
expect('child', end_of(child), 0)
node.destroy_node()
rclpy.shutdown()
print('good')
