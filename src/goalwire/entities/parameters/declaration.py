"""Reads the arguments of declare_parameters: `(name[, value or type[, descriptor]])`, as in rclpy."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.errors import InvalidParameterException
from goalwire.rules.parameters import SEPARATOR, Descriptor, Parameter, ParameterValue, Type
from goalwire.rules.parameters.messages import descriptor_of, value_of

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor

Described: TypeAlias = 'Descriptor | ParameterDescriptor'
"""A descriptor: rcl_interfaces' message, or goalwire's own class, which needs no import of messages."""

_NO_TYPE = (
    "when declaring parameter named '{}', declaring a parameter only providing its name is deprecated. "
    "Write declare_parameter('{}', 1.0) with its default value; or, without one, "
    "declare_parameter('{}', Parameter.Type.DOUBLE), from rclpy.parameter"
)


def declarations(
    namespace: str, given: Sequence[Sequence[Any]], overrides: Mapping[str, ParameterValue]
) -> list[tuple[Parameter, Descriptor]]:
    """Return the parameters, with the values that overrides give to them, and their descriptors.

    Raises TypeError, ValueError, InvalidParameterException; warns of a name without value and type.
    """
    prefix = f'{namespace}{SEPARATOR}' if namespace else ''
    declared = []
    for index, one in enumerate(given):  # a loop, not a comprehension: the warning counts frames
        declared.append(_declaration(prefix, index, one, overrides))
    return declared


def described(descriptor: Described) -> Descriptor:
    """Return a descriptor as goalwire's own class; raises AttributeError for other objects, as in rclpy."""
    if isinstance(descriptor, Descriptor):
        return descriptor
    return descriptor_of(descriptor)


def _declaration(
    prefix: str, index: int, given: Sequence[Any], overrides: Mapping[str, ParameterValue]
) -> tuple[Parameter, Descriptor]:
    where = f'at index {index} in parameters list'
    if not 1 <= len(given) <= 3:
        raise TypeError(f'Invalid parameter tuple length {where}: {given}; expecting length between 1 and 3')
    name, value, descriptor = (*given, None, None)[:3]
    # A message; the name is compared, so that its module need not be imported
    if type(value).__name__ == 'ParameterValue':
        value = value_of(value)
    if not isinstance(name, str):
        raise TypeError(f'First element {name} {where} is not a str.')
    wanted = Descriptor() if descriptor is None else _check(descriptor, where)
    if len(given) == 1:
        warnings.warn(_NO_TYPE.format(name, name, name), UserWarning, stacklevel=5)
        wanted = wanted._replace(dynamic_typing=True)
    full_name = f'{prefix}{name}'
    if not full_name:
        raise InvalidParameterException(full_name)
    wanted = wanted._replace(name=full_name, type=_type(full_name, value, wanted))
    default = None if isinstance(value, Type) else value
    return Parameter(full_name, value=overrides.get(full_name, default)), wanted


def _check(descriptor: Described, where: str) -> Descriptor:
    if not isinstance(descriptor, Descriptor):
        from rcl_interfaces.msg import ParameterDescriptor

        if not isinstance(descriptor, ParameterDescriptor):
            raise TypeError(f'Third element {descriptor} {where} is not a ParameterDescriptor.')
    return described(descriptor)


def _type(name: str, value: object, descriptor: Descriptor) -> Type:
    """Return the type that a declared parameter keeps."""
    if isinstance(value, Type):
        if value is Type.NOT_SET:
            raise ValueError(f'Cannot declare parameter {{{name}}} as statically typed of type NOT_SET')
        if descriptor.dynamic_typing:
            raise ValueError(
                f'When declaring parameter {{{name}}} passing a descriptor with `dynamic_typing=True` '
                'is not allowed when the parameter type is provided'
            )
        return value
    if descriptor.dynamic_typing:
        return Type.NOT_SET  # the type follows the value
    if value is None:
        raise ValueError(
            'Cannot declare a statically typed parameter with default value of type PARAMETER_NOT_SET: '
            f"'{name}' has neither a value nor a type"
        )
    return Type.from_parameter_value(value)
