"""Converts parameters to and from messages of rcl_interfaces.

The message classes are made at the first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.rules.parameters.descriptor import Descriptor, Range
from goalwire.rules.parameters.parameter import FIELDS, ParameterValue, Type

if TYPE_CHECKING:
    from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage

    from goalwire.rules.parameters.outcome import Outcome


def value_of(message: ParameterValueMessage) -> ParameterValue:
    """Return the plain Python value of an rcl_interfaces/msg/ParameterValue, sequences as lists.

    Raises RuntimeError for an unknown type.
    """
    try:
        type_ = Type(message.type)
    except ValueError:
        raise RuntimeError(f'unexpected parameter type {message.type}') from None
    if type_ is Type.NOT_SET:
        return None
    value = getattr(message, FIELDS[type_])
    return value if type_.value <= Type.STRING.value else list(value)


def descriptor_of(message: ParameterDescriptor) -> Descriptor:
    """Return the Descriptor in an rcl_interfaces/msg/ParameterDescriptor; ValueError for an unknown type."""
    return Descriptor(
        name=message.name,
        type=Type(message.type),
        description=message.description,
        additional_constraints=message.additional_constraints,
        read_only=message.read_only,
        dynamic_typing=message.dynamic_typing,
        floating_point_range=tuple(
            Range(limits.from_value, limits.to_value, limits.step) for limits in message.floating_point_range
        ),
        integer_range=tuple(
            Range(limits.from_value, limits.to_value, limits.step) for limits in message.integer_range
        ),
    )


def descriptor_message(descriptor: Descriptor) -> ParameterDescriptor:
    """Return a Descriptor as an rcl_interfaces/msg/ParameterDescriptor."""
    from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor

    return ParameterDescriptor(
        name=descriptor.name,
        type=descriptor.type.value,
        description=descriptor.description,
        additional_constraints=descriptor.additional_constraints,
        read_only=descriptor.read_only,
        dynamic_typing=descriptor.dynamic_typing,
        floating_point_range=[
            FloatingPointRange(**limits._asdict()) for limits in descriptor.floating_point_range
        ],
        integer_range=[IntegerRange(**limits._asdict()) for limits in descriptor.integer_range],
    )


def result_message(outcome: Outcome) -> SetParametersResult:
    """Return the outcome of a set as an rcl_interfaces/msg/SetParametersResult."""
    from rcl_interfaces.msg import SetParametersResult

    return SetParametersResult(successful=outcome.successful, reason=outcome.reason)
