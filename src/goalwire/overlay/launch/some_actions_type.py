"""launch.some_actions_type: the names of ROS 2's module."""

from goalwire.launching.model import (
    SomeEntities as SomeActionsType,
)

__all__ = [
    'SomeActionsType',
]
