"""launch.condition: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    Condition,
)

__all__ = [
    'Condition',
]
