"""launch.some_actions_type: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    SomeEntities as SomeActionsType,
)

__all__ = [
    'SomeActionsType',
]
