"""Calls one service, under whichever rclpy and DDS runs it: many times in turn, then a few times at once.

Arguments: the node's name, how many calls in turn, the seconds to wait for the server and for each answer.
"""

from __future__ import annotations

import sys

import rclpy
from rclpy.task import Future
from std_srvs.srv import SetBool

AT_ONCE = 8
"""More than ten would be too many for a ROS 2 server, which then drops some."""
LENGTHS = {True: 200_000, False: 5}
"""How long the server's answers are."""

name, number = sys.argv[1], int(sys.argv[2])
for_server, for_answer = map(float, sys.argv[3:])
rclpy.init()
node = rclpy.create_node(name)
client = node.create_client(SetBool, 'set')
print('there' if client.wait_for_service(for_server) else 'not there', flush=True)


def call(data: bool) -> Future[SetBool.Response]:
    return client.call_async(SetBool.Request(data=data))


def right(future: Future[SetBool.Response], data: bool) -> bool:
    rclpy.spin_until_future_complete(node, future, timeout_sec=for_answer)
    answer = future.result() if future.done() else None
    return answer is not None and answer.success == data and len(answer.message) == LENGTHS[data]


# The first answer of several packets that Fast DDS sends to a reader is lost to Cyclone DDS now and then.
any(right(call(data=True), data=True) for _ in range(3))
questions = [bool(each % 2) for each in range(number)]
in_turn = sum(right(call(data=each), data=each) for each in questions)
at_once = [(call(data=each), each) for each in questions[:AT_ONCE]]
print('right', in_turn + sum(right(*each) for each in at_once), flush=True)
node.destroy_node()
rclpy.shutdown()
