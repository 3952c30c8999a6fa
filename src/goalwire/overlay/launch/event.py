"""launch.event: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    Event,
)

__all__ = [
    'Event',
]
