"""launch.event: the names of ROS 2's module."""

from goalwire.launching.model import (
    Event,
)

__all__ = [
    'Event',
]
