"""Errors of parameters and their files, and of the QoS that parameters override."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from goalwire.errors.base import LocalError

if TYPE_CHECKING:

    class _Type(Protocol):
        @property
        def name(self) -> str: ...

    class _Parameter(Protocol):
        """The parameter that an error names."""

        @property
        def name(self) -> str: ...
        @property
        def type_(self) -> _Type: ...
        @property
        def value(self) -> object: ...


class ParameterException(LocalError):
    """A parameter was used in a way that is not allowed."""

    def __init__(self, error_msg: str, parameters: object, advice: str = '') -> None:
        super().__init__(f'{error_msg}: {parameters}')
        if advice:
            self.add_note(advice)


class ParameterNotDeclaredException(ParameterException):
    """A parameter was used that was never declared."""

    def __init__(self, parameters: object, hint: str = '') -> None:
        super().__init__('Invalid access to undeclared parameter(s)', parameters, hint)


class ParameterAlreadyDeclaredException(ParameterException):
    """A parameter was declared twice."""

    def __init__(self, parameters: object) -> None:
        super().__init__(
            'Parameter(s) already declared', parameters, "declare each once, or ask 'has_parameter()' before"
        )


class InvalidParameterException(ParameterException):
    """ROS 2 forbids this parameter name."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Invalid parameter name', parameter_name)


class InvalidParameterTypeException(ParameterException):
    """A parameter was to be set to a value of another type than its own."""

    def __init__(self, desired_parameter: _Parameter, expected_type: str) -> None:
        value, name = str(desired_parameter.value), desired_parameter.name
        super().__init__(
            f"Trying to set parameter '{name}' to '{value}' of type '{desired_parameter.type_.name}', "
            f"expecting type '{expected_type}'",
            name,
        )


class InvalidParameterValueException(ParameterException):
    """The parameter's range or a callback refuses the value."""

    def __init__(self, parameter: str, value: object, reason: str) -> None:
        super().__init__(f'Invalid parameter value ({value}) for parameter. Reason: {reason}', parameter)


class ParameterImmutableException(ParameterException):
    """A read-only parameter was to be changed."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__('Attempted to modify read-only parameter', parameter_name)


class ParameterUninitializedException(ParameterException):
    """A parameter was read that has a type but no value yet."""

    def __init__(self, parameter_name: str) -> None:
        super().__init__(f"The parameter '{parameter_name}' is not initialized", parameter_name)


class CallbackError(LocalError, TypeError):
    """A pre-set callback for parameters returned something else than a list of parameters."""


class UnknownCallbackError(LocalError, RuntimeError):
    """A callback was to be removed that was never added, or was removed before."""

    def __init__(self) -> None:
        super().__init__("Callback doesn't exist")


class FileShapeError(LocalError, RuntimeError):
    """A YAML file is not a parameter file."""


class InvalidQoSProfileException(LocalError):
    """A QoS profile was made without a value that it needs."""

    def __init__(self, *args: object) -> None:
        super().__init__('Invalid QoSProfile', *args)
        self.add_note('give the number of messages that are kept: write QoSProfile(depth=10, …)')


class UnknownPolicyError(LocalError, ValueError):
    """A QoS policy cannot be overridden: it does not exist, or its present value is unknown."""


class UnexpectedOverrideError(LocalError, RuntimeError):
    """A QoS policy cannot have the value that overrides it; the text lists the possible values."""


class InvalidQosOverridesError(LocalError):
    """A program's validation callback refuses the QoS that parameters have set
    (rclpy.qos_overriding_options).
    """
