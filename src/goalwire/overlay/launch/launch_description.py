"""launch.launch_description: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    LaunchDescription,
)

__all__ = [
    'LaunchDescription',
]
