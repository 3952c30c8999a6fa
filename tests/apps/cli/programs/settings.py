"""A node with parameters of every type, and one with its name in a namespace."""

import sys
from contextlib import suppress

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.parameter import Parameter
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import String


def main():
    rclpy.init()
    node = rclpy.create_node('settings', namespace='/lab/shelf')
    share = ParameterDescriptor(floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0)])
    for name, value in {
        'bytes': [b'\x00', b'\xff'],
        'flag': True,
        'flags': [True, False],
        'real': 1.5,
        'reals': [1.0, 2.5],
        'text': 'hello',
        'texts': ['yes', '1', 'a: b'],
        'whole': 3,
        'wholes': [1, 2],
    }.items():
        node.declare_parameter(name, value)
    for name, type_ in {
        'empty.bytes': Parameter.Type.BYTE_ARRAY,
        'empty.flags': Parameter.Type.BOOL_ARRAY,
        'empty.reals': Parameter.Type.DOUBLE_ARRAY,
        'empty.texts': Parameter.Type.STRING_ARRAY,
        'empty.wholes': Parameter.Type.INTEGER_ARRAY,
    }.items():
        node.declare_parameter(name, type_)
        node.set_parameters([Parameter(name, type_, [])])
    node.declare_parameter('without.value', Parameter.Type.DOUBLE)
    node.declare_parameter('share', 0.5, share)
    node.declare_parameter('any', 1, ParameterDescriptor(dynamic_typing=True))
    node.declare_parameter('locked', 'in', ParameterDescriptor(read_only=True))
    node.create_publisher(
        String, 'news', 10, qos_overriding_options=QoSOverridingOptions.with_default_policies()
    )
    print('ready', flush=True)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


sys.exit(main())
