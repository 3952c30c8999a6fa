"""Publishes numbers: reliable ones on /numbers, best-effort ones on /fast, and one latched word."""

import itertools

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Int32, String

rclpy.init()
node = rclpy.create_node('counter')
numbers = node.create_publisher(Int32, 'numbers', 100)
fast = node.create_publisher(Int32, 'fast', QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
word = node.create_publisher(String, 'word', latched)
word.publish(String(data='I came first'))
counted = itertools.count()


def publish():
    count = next(counted)
    numbers.publish(Int32(data=count))
    fast.publish(Int32(data=count))


node.create_timer(0.01, publish)
print('ready', flush=True)
rclpy.spin(node)
