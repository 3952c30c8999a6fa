"""Leaves in the middle of incoming traffic. Argument: how.

nothing closed    the end of the program is reached, nothing is destroyed or shut down
sys.exit          from within a callback
shutdown          the context is shut down, the node is not destroyed
interrupted       spins on until Ctrl-C, which nothing guards
"""

import sys
from itertools import count

import rclpy
from rclpy.task import Future
from std_msgs.msg import String

how = sys.argv[1]
rclpy.init()
node = rclpy.create_node('leaving')
enough: Future[None] = Future()
seen = count(1).__next__


def on_message(_: String) -> None:
    if seen() == 20:
        print('in the middle of traffic')
        if how == 'sys.exit':
            sys.exit(0)
        enough.set_result(None)


subscription = node.create_subscription(String, 'flood', on_message, 10)
rclpy.spin_until_future_complete(node, enough)
if how == 'shutdown':
    rclpy.shutdown()
if how == 'interrupted':
    rclpy.spin(node)
