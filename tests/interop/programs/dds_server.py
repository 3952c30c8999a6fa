"""Answers on one service, under whichever rclpy and DDS runs it, and says what it was asked.

A request for true gets a long answer, one for false a short one.
"""

from __future__ import annotations

import sys
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from std_srvs.srv import SetBool

rclpy.init()
node = rclpy.create_node(sys.argv[1])


def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    print('asked', request.data, flush=True)
    response.success = request.data
    response.message = 'long' * 50_000 if request.data else 'short'
    return response


node.create_service(SetBool, 'set', answer)
print('ready', flush=True)
with suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
