"""launch.launch_context: the names of ROS 2's module."""

from goalwire.launching.model import (
    LaunchContext,
)

__all__ = [
    'LaunchContext',
]
