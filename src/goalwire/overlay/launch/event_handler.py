"""launch.event_handler: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    EventHandler,
)

__all__ = [
    'EventHandler',
]
