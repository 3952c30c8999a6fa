"""The topics and services that every node of ROS 2 has: tests of a program's own ones leave them out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

STANDING_TOPICS = frozenset({'/parameter_events', '/rosout'})
STANDING_SERVICES = frozenset(
    {
        'describe_parameters',
        'get_parameters',
        'get_parameter_types',
        'list_parameters',
        'set_parameters',
        'set_parameters_atomically',
        'get_type_description',
    }
)

T = TypeVar('T', bound=Sequence[object])


def own(names: Iterable[T]) -> list[T]:
    """Leave out the standing topics and services of `(name, types)`."""
    return [
        named
        for named in names
        if named[0] not in STANDING_TOPICS and str(named[0]).rpartition('/')[2] not in STANDING_SERVICES
    ]
