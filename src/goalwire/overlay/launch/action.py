"""launch.action: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    Action,
)

__all__ = [
    'Action',
]
