"""Makes and destroys nodes with entities; reports what the process holds before and after.

Arguments: how many before the first report, how many between the first and the second. One node in ten has
an action server and an action client as well.
"""

import gc
import os
import sys
from pathlib import Path

import rclpy
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rclpy.action import ActionClient, ActionServer
from std_msgs.msg import String


def churn(number: int) -> None:
    for each in range(number):
        node = rclpy.create_node('short_lived')
        node.create_publisher(String, 'topic', 10)
        node.create_subscription(String, 'topic', print, 10)
        node.create_service(AddTwoInts, 'service', lambda _, response: response)
        node.create_client(AddTwoInts, 'service')
        node.create_timer(1.0, print)
        if each % 10 == 0:
            ActionServer(node, Fibonacci, 'action', lambda _: Fibonacci.Result())
            ActionClient(node, Fibonacci, 'action')
        rclpy.spin_once(node, timeout_sec=0.0)
        node.destroy_node()


def report(title: str) -> None:
    gc.collect()
    descriptors = len(list(Path('/proc/self/fd').iterdir()))
    threads = len(list(Path('/proc/self/task').iterdir()))
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    print(title, descriptors, threads, pages * os.sysconf('SC_PAGE_SIZE') // 1024)


with rclpy.init():
    before, between = map(int, sys.argv[1:])
    churn(before)
    report('before')
    churn(between)
    report('after')
    print('left', sorted(rclpy.create_node('last').get_node_names()))
