"""Answers each call with the number of calls so far, until its standard input ends."""

from __future__ import annotations

import sys
import threading
from itertools import count

import rclpy
from std_srvs.srv import SetBool

numbers = count(1)


def answer(_request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.message = str(next(numbers))
    return response


rclpy.init()
node = rclpy.create_node('counts_calls')
node.create_service(SetBool, 'count', answer)
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
print('ready', flush=True)
sys.stdin.read()
rclpy.shutdown()
spinning.join()
