"""Sends one goal of a given order and waits for its end, whatever that is."""

import sys

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node

with rclpy.init():
    client = ActionClient(Node('sender'), Fibonacci, 'watched')
    assert client.wait_for_server(timeout_sec=30.0)
    print('sending', flush=True)
    client.send_goal(Fibonacci.Goal(order=int(sys.argv[1])))
