"""launch_ros.event_handlers: offers the names of ROS 2's module of this name."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.ros.lifecycle import (
    OnStateTransition,
)

__all__ = [
    'OnStateTransition',
]

add_modules(__name__)
