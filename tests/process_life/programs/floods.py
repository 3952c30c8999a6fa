"""A program that lets SIGPIPE kill it, as many that write to pipes do, publishes while its peers die."""

from __future__ import annotations

import signal
import sys
import threading
from queue import SimpleQueue

import rclpy
from std_msgs.msg import String

signal.signal(signal.SIGPIPE, signal.SIG_DFL)
rclpy.init()
node = rclpy.create_node('floods')
publisher = node.create_publisher(String, 'flood', 10)
lines: SimpleQueue[str] = SimpleQueue()


def read() -> None:
    for line in sys.stdin:
        lines.put(line.strip())


threading.Thread(target=read, daemon=True).start()
print('ready')
message = String(data=1000 * 'x')
while True:
    for _ in range(500):
        publisher.publish(message)
    if not lines.empty():
        if lines.get() == 'leave':
            break
        print('five hundred more')
node.destroy_node()
rclpy.shutdown()
print('end')
