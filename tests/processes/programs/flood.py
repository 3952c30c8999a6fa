"""Publishes as fast as it can to whoever is there, until asked to stop; sleeps while nobody is."""

import rclpy
from rclpy.event_handler import PublisherEventCallbacks, QoSPublisherMatchedInfo
from std_msgs.msg import String

AT_ONCE = 100
there = [0]


def on_matched(matched: QoSPublisherMatchedInfo) -> None:
    there[0] = matched.current_count


rclpy.init()
node = rclpy.create_node('flood')
publisher = node.create_publisher(
    String, 'flood', 10, event_callbacks=PublisherEventCallbacks(matched=on_matched)
)
message = String(data='x' * 100)
try:
    print('ready')
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.0 if there[0] else None)
        for _ in range(AT_ONCE if there[0] else 0):
            publisher.publish(message)
except KeyboardInterrupt:
    print('stopped')
