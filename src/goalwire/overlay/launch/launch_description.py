"""launch.launch_description: the names of ROS 2's module."""

from goalwire.launching.model import (
    LaunchDescription,
)

__all__ = [
    'LaunchDescription',
]
