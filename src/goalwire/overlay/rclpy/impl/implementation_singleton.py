"""rclpy.impl.implementation_singleton: what programs take from rclpy's C extension, exceptions above all."""

from types import SimpleNamespace

from goalwire.entities.exceptions import (
    InvalidHandle,
    NodeNameNonExistentError,
    RCLError,
    RCLInvalidROSArgsError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
from goalwire.entities.service_introspection import ServiceIntrospectionState
from rclpy.clock_type import ClockType
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier

package = 'rclpy'

rclpy_implementation = SimpleNamespace(
    ClockType=ClockType,
    InvalidHandle=InvalidHandle,
    NodeNameNonExistentError=NodeNameNonExistentError,
    RCLError=RCLError,
    RCLInvalidROSArgsError=RCLInvalidROSArgsError,
    RCUTILS_LOG_SEVERITY=LoggingSeverity,
    SignalHandlerOptions=SignalHandlerOptions,
    UnknownROSArgsError=UnknownROSArgsError,
    UnsupportedEventTypeError=UnsupportedEventTypeError,
    rclpy_deserialize=deserialize_message,
    rclpy_get_rmw_implementation_identifier=get_rmw_implementation_identifier,
    rclpy_serialize=lambda message, _message_type: serialize_message(message),
    service_introspection=SimpleNamespace(ServiceIntrospectionState=ServiceIntrospectionState),
)
