"""Calls into /to_peer, again and again, until the echo comes back from /from_peer."""

import rclpy
from rclpy.task import Future
from std_msgs.msg import String

SENTENCE = 'grüße, 世界'

with rclpy.init():
    node = rclpy.create_node('echo_caller')
    echo: Future[str] = Future()
    node.create_subscription(String, 'from_peer', lambda message: echo.set_result(message.data), 10)
    publisher = node.create_publisher(String, 'to_peer', 10)
    timer = node.create_timer(0.1, lambda: publisher.publish(String(data=SENTENCE)))
    print('ready')
    rclpy.spin_until_future_complete(node, echo, timeout_sec=20.0)
    assert echo.result() == f'echo of {SENTENCE}'
    print('peers:', *sorted(name for name in node.get_node_names() if name != 'echo_caller'))
