"""A program that ends without shutdown, beside a daemon thread whose callbacks publish all the time."""

from __future__ import annotations

import sys
import threading

import rclpy
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node('spinning_daemon')
publisher = node.create_publisher(String, 'all_the_time', 10)
came = threading.Semaphore(0)


def again(message: String) -> None:
    came.release()
    publisher.publish(message)


node.create_subscription(String, 'all_the_time', again, 10)
node.create_timer(0.0005, lambda: publisher.publish(String(data='tick')))
executor = SingleThreadedExecutor() if sys.argv[1] == 'single' else MultiThreadedExecutor()
executor.add_node(node)
threading.Thread(target=executor.spin, daemon=True).start()
for _ in range(20):
    came.acquire(timeout=20)
print('end of main')
