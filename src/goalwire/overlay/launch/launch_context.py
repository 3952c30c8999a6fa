"""launch.launch_context: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    LaunchContext,
)

__all__ = [
    'LaunchContext',
]
