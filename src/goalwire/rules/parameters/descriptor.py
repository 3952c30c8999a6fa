"""Descriptors: they limit the values of a parameter (rcl_interfaces/msg/ParameterDescriptor).

The rules, and the texts of refusals, are those of rclpy (rclpy.node).
"""

from __future__ import annotations

import math
from typing import Generic, NamedTuple, TypeVar

from goalwire.rules.parameters.outcome import ACCEPTED, Outcome, WrongType, refuse
from goalwire.rules.parameters.parameter import Parameter, Type

RELATIVE_TOLERANCE = 1e-6
"""The relative tolerance with which a double counts as equal to an end or a step of a range."""


NumberT = TypeVar('NumberT', int, float)


class Range(NamedTuple, Generic[NumberT]):
    """The values between two ends, both inclusive, in steps from the lower end (step 0: any value)."""

    from_value: NumberT
    to_value: NumberT
    step: NumberT

    @property
    def lowest(self) -> NumberT:
        """The range's lower end. ROS 2 accepts the two ends in either order."""
        return min(self.from_value, self.to_value)

    @property
    def highest(self) -> NumberT:
        """The range's upper end."""
        return max(self.from_value, self.to_value)


class Descriptor(NamedTuple):
    """The description of a parameter. Each of its two lists of ranges has at most one entry."""

    name: str = ''
    type: Type = Type.NOT_SET
    description: str = ''
    additional_constraints: str = ''
    read_only: bool = False
    dynamic_typing: bool = False
    floating_point_range: tuple[Range[float], ...] = ()
    integer_range: tuple[Range[int], ...] = ()

    def judge(self, parameter: Parameter, *, declared: bool = False) -> Outcome:
        """Return whether the parameter may have this value.

        `declared`: True if the parameter is declared already. Whether the parameter is read-only is not
        checked.
        """
        if not self.dynamic_typing:
            if parameter.type_ is Type.NOT_SET:
                return refuse('Static parameter cannot be undeclared') if declared else ACCEPTED
            if parameter.type_ is not self.type:
                reason = f"Wrong parameter type, expected '{self.type}' got '{parameter.type_}'"
                return refuse(reason, WrongType)
        value = parameter.value
        if self.integer_range and parameter.type_ is Type.INTEGER and isinstance(value, int):
            return _judge_integer(parameter.name, value, self.integer_range[0])
        if self.floating_point_range and parameter.type_ is Type.DOUBLE and isinstance(value, float):
            return _judge_double(parameter.name, value, self.floating_point_range[0])
        return ACCEPTED


def _judge_integer(name: str, value: int, range_: Range[int]) -> Outcome:
    low, high, step = range_.lowest, range_.highest, range_.step
    if value in {low, high}:
        return ACCEPTED
    if not low < value < high:
        return refuse(f'Parameter {name} out of range. Min: {low}, Max: {high}, value: {value}')
    if step and (value - low) % step:
        return refuse(
            f'The parameter value for {name} is not a valid step. '
            f'Min: {low}, max: {high}, value: {value}, step: {step}'
        )
    return ACCEPTED


def _judge_double(name: str, value: float, range_: Range[float]) -> Outcome:
    low, high, step = range_.lowest, range_.highest, range_.step
    if _near(value, low) or _near(value, high):
        return ACCEPTED
    if not low < value < high:  # this condition is also true for NaN
        return refuse(f'Parameter {name} out of range Min: {low}, Max: {high}, value: {value}')
    if step and not _near(low + round((value - low) / step) * step, value):
        return refuse(
            f'The parameter value for {name} is not close enough to a valid step. '
            f'Min: {low}, max: {high}, value: {value}, step: {step}'
        )
    return ACCEPTED


def _near(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=RELATIVE_TOLERANCE)
