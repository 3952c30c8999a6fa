"""Takes calls and goals, and comes to the end of none."""

import threading
from typing import NoReturn

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger


def hold(*_: object) -> NoReturn:
    print('began\n', end='', flush=True)  # in one piece: several threads are here at once
    threading.Event().wait()
    raise AssertionError('nobody sets it')


with rclpy.init():
    node = Node('holder')
    group = ReentrantCallbackGroup()
    node.create_service(Trigger, 'hold', hold, callback_group=group)
    ActionServer(node, Fibonacci, 'hold_on', hold, callback_group=group)
    print('ready', flush=True)
    executor = MultiThreadedExecutor(8)
    executor.add_node(node)
    executor.spin()
