"""The numbers of a message by their names, as a vector of a dataset needs them.

Messages that name their joints give a number for each joint. Other messages give a number for each numeric
field, such as `linear.x`; the elements of a list are named by their positions, such as `data.0`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from goalwire.idl.model import Field, Shape
from goalwire.idl.registry import message_definition
from goalwire.observe.messages import fields_of

JOINT_STATE = 'sensor_msgs/msg/JointState'
_JOINT_TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'
_LEFT_OUT = frozenset(
    {
        'builtin_interfaces/msg/Duration',
        'builtin_interfaces/msg/Time',
        'std_msgs/msg/Header',
        'std_msgs/msg/MultiArrayLayout',
    }
)
"""Types of fields that say when, where or how numbers were measured."""

Numbers = Mapping[str, float]


def reader_of(type_name: str, cls: type) -> Callable[[Any], Numbers]:
    """Return the function that reads the numbers of a type's messages."""
    if type_name == JOINT_STATE:
        return _read_joint_state
    if type_name == _JOINT_TRAJECTORY:
        return _read_trajectory
    return partial(_read_fields, fields_of(cls))


def _read_joint_state(message: Any) -> Numbers:
    """Read the positions; if a message has none, as a command of speeds, read its velocities or efforts."""
    for values in (message.position, message.velocity, message.effort):
        if len(values) and len(values) == len(message.name):
            return dict(zip(message.name, values, strict=True))
    return {}


def _read_trajectory(message: Any) -> Numbers:
    """Read the positions of the last point: the trajectory leads there."""
    if not message.points:
        return {}
    return dict(zip(message.joint_names, message.points[-1].positions, strict=False))


def _read_fields(fields: Iterable[Field], message: Any) -> Numbers:
    return dict(_walk(fields, message, ''))


def _walk(fields: Iterable[Field], message: Any, before: str) -> Iterator[tuple[str, float]]:
    for field in fields:
        type_, name = field.type, f'{before}{field.name}'
        if type_.base in _LEFT_OUT:
            continue
        value = getattr(message, field.name)
        if type_.is_message:
            if type_.shape is Shape.SINGLE:
                yield from _walk(message_definition(type_.base).fields, value, f'{name}.')
        elif not (type_.is_number or type_.base == 'bool'):
            continue
        elif type_.shape is Shape.SINGLE:
            yield name, value
        else:
            yield from ((f'{name}.{position}', each) for position, each in enumerate(value))
