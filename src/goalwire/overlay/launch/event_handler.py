"""launch.event_handler: the names of ROS 2's module."""

from goalwire.launching.model import (
    EventHandler,
)

__all__ = [
    'EventHandler',
]
