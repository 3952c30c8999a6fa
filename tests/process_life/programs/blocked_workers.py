"""A program that ends without shutdown while COUNT callbacks block for ever."""

from __future__ import annotations

import sys
import threading
import time

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor

COUNT = int(sys.argv[1])

rclpy.init()
node = rclpy.create_node('blocked_workers')
executor = MultiThreadedExecutor(COUNT + 2)
executor.add_node(node)
group = ReentrantCallbackGroup()
begun = threading.Semaphore(0)


def block() -> None:
    begun.release()
    threading.Event().wait()


for _ in range(COUNT):
    node.create_timer(0.001, block, callback_group=group)
threading.Thread(target=executor.spin, daemon=True).start()
for _ in range(COUNT):
    begun.acquire(timeout=20)
print('end of main at', time.monotonic())
