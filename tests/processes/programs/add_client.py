"""Waits for a service and calls it once."""

import rclpy
from example_interfaces.srv import AddTwoInts

with rclpy.init():
    node = rclpy.create_node('add_client')
    client = node.create_client(AddTwoInts, 'add')
    print('waiting')
    assert client.wait_for_service(timeout_sec=20.0)
    future = client.call_async(AddTwoInts.Request(a=2, b=3))
    rclpy.spin_until_future_complete(node, future)
    answer = future.result()
    assert answer is not None
    print(f'2 + 3 = {answer.sum}')
