"""The part of rclpy's C extension that programs use: its exceptions, some functions that take handles, and
entities for waitables and wait sets of a program's own.
"""

from collections.abc import Sequence
from types import SimpleNamespace

from goalwire.entities.bare_entities import (
    Client,
    EventHandle,
    GuardCondition,
    Service,
    Subscription,
    Timer,
)
from goalwire.entities.node import NodeCore
from goalwire.entities.service_introspection import ServiceIntrospectionState
from goalwire.errors import (
    InvalidHandle,
    NodeNameNonExistentError,
    RCLError,
    RCLInvalidROSArgsError,
    RCUtilsError,
    RMWError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
from goalwire.execution.wait_sets.blocking_wait_set import BlockingWaitSet
from goalwire.rules.qos import QoS
from rclpy import qos
from rclpy.clock_type import ClockType
from rclpy.expand_topic_name import expand_topic_name
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier, remove_ros_args

__all__ = [
    'RCUTILS_LOG_SEVERITY',
    'Client',
    'ClockType',
    'EventHandle',
    'GuardCondition',
    'InvalidHandle',
    'NodeNameNonExistentError',
    'RCLError',
    'RCLInvalidROSArgsError',
    'RCUtilsError',
    'RMWError',
    'Service',
    'SignalHandlerOptions',
    'Subscription',
    'Timer',
    'UnknownROSArgsError',
    'UnsupportedEventTypeError',
    'WaitSet',
    'rclpy_deserialize',
    'rclpy_expand_topic_name',
    'rclpy_get_rmw_implementation_identifier',
    'rclpy_remap_topic_name',
    'rclpy_remove_ros_args',
    'rclpy_resolve_name',
    'rclpy_serialize',
    'rmw_qos_profile_t',
    'service_introspection',
]


class rmw_qos_profile_t:
    """The predefined profiles of ROS 2."""

    @staticmethod
    def predefined(qos_profile_name: str) -> QoS:
        """Return the profile named for example 'qos_profile_default'; raises ValueError for unknown names."""
        try:
            profile: qos.QoSProfile = getattr(qos, qos_profile_name)
            return profile.get_c_qos_profile()
        except AttributeError:
            raise ValueError(f"there is no predefined QoS profile '{qos_profile_name}'") from None


RCUTILS_LOG_SEVERITY = LoggingSeverity
WaitSet = BlockingWaitSet
service_introspection = SimpleNamespace(ServiceIntrospectionState=ServiceIntrospectionState)
rclpy_deserialize = deserialize_message
rclpy_expand_topic_name = expand_topic_name
rclpy_get_rmw_implementation_identifier = get_rmw_implementation_identifier


def rclpy_serialize(message: object, _message_type: type) -> bytes:
    """Return a message as serialized bytes; raises EncodeError."""
    return serialize_message(message)


def rclpy_remap_topic_name(node: NodeCore, topic_name: str) -> str:
    """Return the name that the remapping rules of a node (Node.handle) give to a fully-qualified name."""
    return node.resolve(topic_name)


def rclpy_resolve_name(node: NodeCore, name: str, only_expand: bool, is_service: bool) -> str:
    """Return the fully-qualified name of a topic or service of a node (Node.handle)."""
    return node.resolve(name, is_service=is_service, only_expand=only_expand)


def rclpy_remove_ros_args(args: Sequence[str]) -> list[str]:
    """Return `args` without the part `--ros-args … --`; raises RCLInvalidROSArgsError."""
    return remove_ros_args(args)
