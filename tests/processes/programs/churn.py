"""Makes and destroys nodes with entities. Pauses three times, so that it may be seen what the process holds.

Arguments: how many before the first pause, and how many from each pause to the next. One node in ten has an
action server and an action client as well.
"""

import gc
import sys

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


def pause(title: str) -> None:
    gc.collect()
    print(title)
    input()


with rclpy.init():
    before, between = map(int, sys.argv[1:])
    churn(before)
    pause('before')
    for title in ('between', 'after'):
        churn(between)
        pause(title)
    print('left', sorted(rclpy.create_node('last').get_node_names()))
