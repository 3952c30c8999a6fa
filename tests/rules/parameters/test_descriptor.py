"""Which values a descriptor lets pass, and what it says of the others."""

from __future__ import annotations

import math
from typing import Any

import pytest

from goalwire.rules.parameters import Descriptor, Parameter, Range, Type, WrongType
from goalwire.rules.parameters.messages import descriptor_message, descriptor_of

INTEGER = Descriptor('i', Type.INTEGER)


def reason(descriptor: Descriptor, value: Any, *, declared: bool = True) -> str:
    outcome = descriptor.judge(Parameter(descriptor.name, value=value), declared=declared)
    assert outcome.successful is not bool(outcome.reason)
    return outcome.reason


def test_a_parameter_keeps_its_type() -> None:
    outcome = INTEGER.judge(Parameter('i', value='x'))
    assert outcome == (False, "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'")
    assert isinstance(outcome, WrongType)
    assert reason(INTEGER, 2) == ''


def test_a_parameter_of_one_type_cannot_lose_its_value_but_may_begin_without_one() -> None:
    assert reason(INTEGER, None) == 'Static parameter cannot be undeclared'
    assert reason(INTEGER, None, declared=False) == ''


@pytest.mark.parametrize('value', [1, 's', None, [1.5]], ids=repr)
def test_a_dynamically_typed_parameter_takes_any_type(value: Any) -> None:
    assert reason(Descriptor('d', Type.INTEGER, dynamic_typing=True), value) == ''


@pytest.mark.parametrize('ends', [(0, 10), (10, 0)])
@pytest.mark.parametrize(
    ('value', 'refusal'),
    [
        (0, ''),
        (5, ''),
        (10, ''),
        (11, 'Parameter i out of range. Min: 0, Max: 10, value: 11'),
        (-1, 'Parameter i out of range. Min: 0, Max: 10, value: -1'),
        (7, 'The parameter value for i is not a valid step. Min: 0, max: 10, value: 7, step: 5'),
    ],
)
def test_an_integer_lies_in_its_range_on_a_step(ends: tuple[int, int], value: int, refusal: str) -> None:
    descriptor = Descriptor('i', Type.INTEGER, integer_range=(Range(*ends, 5),))
    assert reason(descriptor, value) == refusal


def test_steps_count_from_the_lower_end_and_the_upper_end_is_always_right() -> None:
    descriptor = Descriptor('i', Type.INTEGER, integer_range=(Range(1, 8, 3),))
    assert [value for value in range(10) if not reason(descriptor, value)] == [1, 4, 7, 8]


@pytest.mark.parametrize(
    ('value', 'refusal'),
    [
        (0.0, ''),
        (0.3, ''),
        (0.30000001, ''),
        (1.0000001, ''),
        (1.1, 'Parameter f out of range Min: 0.0, Max: 1.0, value: 1.1'),
        (-0.1, 'Parameter f out of range Min: 0.0, Max: 1.0, value: -0.1'),
        (math.nan, 'Parameter f out of range Min: 0.0, Max: 1.0, value: nan'),
        (math.inf, 'Parameter f out of range Min: 0.0, Max: 1.0, value: inf'),
        (
            0.35,
            (
                'The parameter value for f is not close enough to a valid step. '
                'Min: 0.0, max: 1.0, value: 0.35, step: 0.1'
            ),
        ),
    ],
)
def test_a_double_lies_in_its_range_near_a_step(value: float, refusal: str) -> None:
    descriptor = Descriptor('f', Type.DOUBLE, floating_point_range=(Range(0.0, 1.0, 0.1),))
    assert reason(descriptor, value) == refusal


@pytest.mark.parametrize('value', ['x', [1, 99], 99.5], ids=repr)
def test_a_range_is_for_values_of_its_own_type_alone(value: Any) -> None:
    type_ = Type.from_parameter_value(value)
    assert reason(Descriptor('i', type_, integer_range=(Range(0, 3, 0),)), value) == ''


def test_a_dynamically_typed_integer_lies_in_its_range() -> None:
    descriptor = Descriptor('d', dynamic_typing=True, integer_range=(Range(0, 10, 0),))
    assert reason(descriptor, 'text') == ''
    assert reason(descriptor, 50) == 'Parameter d out of range. Min: 0, Max: 10, value: 50'


def test_a_descriptor_survives_being_a_message() -> None:
    descriptor = Descriptor(
        'd', Type.DOUBLE, 'what', 'how', True, True, (Range(0.0, 1.0, 0.5),), (Range(1, 5, 2),)
    )
    assert descriptor_of(descriptor_message(descriptor)) == descriptor
