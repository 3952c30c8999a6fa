"""A node with a parameter in a range, that others may set."""

import rclpy
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.node import Node

with rclpy.init():
    node = Node('limits', namespace='lab')
    descriptor = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=100, step=5)])
    node.declare_parameter('speed', 10, descriptor)
    print('ready', node.get_parameter('speed').value, flush=True)
    rclpy.spin(node)
