"""Calls /switch: on, then off."""

import rclpy
from std_srvs.srv import SetBool

with rclpy.init():
    node = rclpy.create_node('switch_client')
    client = node.create_client(SetBool, 'switch')
    assert client.wait_for_service(timeout_sec=20.0)
    for on in (True, False):
        future = client.call_async(SetBool.Request(data=on))
        rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
        answer = future.result()
        assert answer is not None
        print(answer.success, answer.message)
