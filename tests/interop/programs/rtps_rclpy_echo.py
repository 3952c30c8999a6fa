"""Publishes on /pong what comes on /ping, and has said something on /latched; on any rclpy and RMW."""

import contextlib
import sys

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

reliability = ReliabilityPolicy[sys.argv[1]]
rclpy.init()
node = rclpy.create_node('echo')
qos = QoSProfile(depth=10, reliability=reliability)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
publisher = node.create_publisher(String, 'pong', qos)
node.create_subscription(String, 'ping', publisher.publish, qos)
early = node.create_publisher(String, 'latched', latched)
early.publish(String(data='said before'))


def hear(message: String) -> None:
    print('latched:', message.data, flush=True)


node.create_subscription(String, 'latched_ping', hear, latched)
print('ready', flush=True)
with contextlib.suppress(ExternalShutdownException, KeyboardInterrupt):
    rclpy.spin(node)
node.destroy_node()
rclpy.try_shutdown()
