"""rclpy's C extension gives programs the things that the public modules have."""

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.serialization import serialize_message
from rclpy.service_introspection import ServiceIntrospectionState
from std_msgs.msg import String


def test_exceptions_are_those_that_are_raised() -> None:
    assert _rclpy.InvalidHandle is InvalidHandle
    assert issubclass(_rclpy.UnknownROSArgsError, _rclpy.RCLError)


def test_messages_go_there_and_back() -> None:
    message = String(data='x')
    data = _rclpy.rclpy_serialize(message, String)
    assert data == serialize_message(message)
    assert _rclpy.rclpy_deserialize(data, String) == message


def test_introspection_states_are_the_public_ones() -> None:
    assert _rclpy.service_introspection.ServiceIntrospectionState is ServiceIntrospectionState


def test_names_are_resolved_with_the_node_s_handle() -> None:
    context = Context()
    rclpy.init(context=context, args=['--ros-args', '-r', '/a/x:=/b/y'])
    try:
        node = rclpy.create_node('n', namespace='/a', context=context)
        with node.handle as handle:
            assert _rclpy.rclpy_remap_topic_name(handle, '/a/x') == '/b/y'
            assert _rclpy.rclpy_resolve_name(handle, 'x', False, False) == '/b/y'
            assert _rclpy.rclpy_resolve_name(handle, '~/x', True, True) == '/a/n/x'
        assert node.get_name() == 'n'  # leaving the block let go of the handle, no more
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
