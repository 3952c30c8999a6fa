"""The exceptions that programs written for rclpy catch, under rclpy's names (rclpy.exceptions, rclpy.node).

Each is also one of goalwire's own (goalwire.errors), so that either family catches it.
"""

from __future__ import annotations

from goalwire.errors import (
    ClosedError,
    InvalidHandle,
    LocalError,
    NotInitializedException,
    ROSInterruptException,
)
from goalwire.files import shown
from goalwire.rules.names.validation import LONGEST_SHOWN, pointed
from goalwire.rules.parameters import Parameter

__all__ = [
    'InvalidHandle',
    'InvalidNamespaceException',
    'InvalidNodeNameException',
    'InvalidParameterException',
    'InvalidParameterTypeException',
    'InvalidParameterValueException',
    'InvalidQosOverridesError',
    'InvalidServiceNameException',
    'InvalidTopicNameException',
    'NameValidationException',
    'NoTypeSupportImportedException',
    'NodeNameNonExistentError',
    'NotInitializedException',
    'ParameterAlreadyDeclaredException',
    'ParameterException',
    'ParameterImmutableException',
    'ParameterNotDeclaredException',
    'ParameterUninitializedException',
    'RCLError',
    'RCLInvalidROSArgsError',
    'RCUtilsError',
    'RMWError',
    'ROSInterruptException',
    'ShutDownError',
    'TopicExpansionError',
    'UnknownROSArgsError',
    'UnsupportedEventTypeError',
]


class RCLError(LocalError, RuntimeError):
    """What rclpy raises where its C library refuses."""


class RMWError(LocalError, RuntimeError):
    """What rclpy raises where its middleware refuses; goalwire never does, programs catch it."""


class RCUtilsError(LocalError, RuntimeError):
    """What rclpy raises where its C helpers refuse; goalwire never does, programs catch it."""


class ShutDownError(RCLError, ClosedError):
    """An entity was used after the end of its context."""

    def __init__(self, what: str) -> None:
        super().__init__(f'{what}: the context was shut down; ask rclpy.ok() before, or stop using it first')


class RCLInvalidROSArgsError(RCLError):
    """Arguments after --ros-args that do not parse."""


class UnknownROSArgsError(RCLError):
    """Arguments after --ros-args that ROS 2 does not know."""


class InvalidQosOverridesError(LocalError):
    """A program refuses the QoS that its parameters make (rclpy.qos_overriding_options)."""


class UnsupportedEventTypeError(RCLError):
    """An event that the wire in use cannot tell (rclpy.event_handler)."""

    def __init__(self, event: str, topic: str, wire: str) -> None:
        super().__init__(
            f"Failed to initialize event: {event} is not supported by {wire} (topic '{topic}'): "
            f'leave this callback out on this wire'
        )


class NodeNameNonExistentError(RCLError):
    """A graph question about a node that is not there."""


class NoTypeSupportImportedException(LocalError):
    """A message class without type support."""

    def __init__(self) -> None:
        super().__init__('no type_support imported')


class TopicExpansionError(LocalError, ValueError):
    """A topic name, node name or namespace from which no full name can be made."""

    def __init__(self, kind: str, name: str, reason: str) -> None:
        what = 'node namespace' if kind == 'namespace' else kind
        super().__init__(f"{what} '{shown(name, LONGEST_SHOWN)}' is invalid: {shown(reason, LONGEST_SHOWN)}")
        self.reason = reason


class NameValidationException(LocalError):
    """A name that ROS 2 forbids for that `reason`; the text points at the character."""

    def __init__(self, name_type: str, name: str, error_msg: str, invalid_index: int) -> None:
        self.reason = error_msg
        super().__init__(pointed(name_type, name, error_msg, invalid_index))


class InvalidNodeNameException(NameValidationException):
    """A node name that ROS 2 forbids."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('node name', name, error_msg, invalid_index)


class InvalidNamespaceException(NameValidationException):
    """A namespace that ROS 2 forbids."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('namespace', name, error_msg, invalid_index)


class InvalidTopicNameException(NameValidationException):
    """A topic name that ROS 2 forbids."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('topic name', name, error_msg, invalid_index)


class InvalidServiceNameException(NameValidationException):
    """A service name that ROS 2 forbids."""

    def __init__(self, name: str, error_msg: str, invalid_index: int) -> None:
        super().__init__('service name', name, error_msg, invalid_index)


class ParameterException(LocalError):
    """A parameter that may not be used like that."""

    def __init__(self, error_msg: str, parameters: object) -> None:
        super().__init__(f'{error_msg}: {parameters}')


class ParameterNotDeclaredException(ParameterException):
    """A parameter that was never declared."""

    def __init__(self, parameters: object) -> None:
        super().__init__('Invalid access to undeclared parameter(s)', parameters)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter declared twice."""

    def __init__(self, parameters: object) -> None:
        super().__init__('Parameter(s) already declared', parameters)


class InvalidParameterException(ParameterException):
    """A parameter name that ROS 2 forbids."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Invalid parameter name', parameter_name)


class InvalidParameterTypeException(ParameterException):
    """A value of another type than the parameter has."""

    def __init__(self, desired_parameter: Parameter, expected_type: str) -> None:
        value, name = str(desired_parameter.value), desired_parameter.name
        super().__init__(
            f"Trying to set parameter '{name}' to '{value}' of type '{desired_parameter.type_.name}', "
            f"expecting type '{expected_type}'",
            name,
        )


class InvalidParameterValueException(ParameterException):
    """A value that the parameter refuses."""

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        super().__init__(f'Invalid parameter value ({value}) for parameter. Reason: {reason}', parameter)


class ParameterImmutableException(ParameterException):
    """A read-only parameter that was to be changed."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Attempted to modify read-only parameter', parameter_name)


class ParameterUninitializedException(ParameterException):
    """A parameter that has a type and no value yet."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__(f"The parameter '{parameter_name}' is not initialized", parameter_name)
