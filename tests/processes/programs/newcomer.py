"""Joins when told which service to call, calls it once, and says how long that took.

Everything is imported before, so that what is measured is the joining.
"""

import time

import rclpy
from example_interfaces.srv import AddTwoInts

print('ready')
service = input()
began = time.monotonic()
with rclpy.init():
    node = rclpy.create_node('newcomer')
    client = node.create_client(AddTwoInts, service)
    assert client.wait_for_service(timeout_sec=20.0)
    future = client.call_async(AddTwoInts.Request(a=1, b=2))
    rclpy.spin_until_future_complete(node, future)
    answer = future.result()
    assert answer is not None
    assert answer.sum == 3
    print(f'answered after {time.monotonic() - began:.3f} s')
