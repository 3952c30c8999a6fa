"""launch.condition: the names of ROS 2's module."""

from goalwire.launching.model import (
    Condition,
)

__all__ = [
    'Condition',
]
