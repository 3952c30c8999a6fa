"""launch.action: the names of ROS 2's module."""

from goalwire.launching.model import (
    Action,
)

__all__ = [
    'Action',
]
