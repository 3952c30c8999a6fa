"""launch.launch_service: the names of ROS 2's module."""

from goalwire.launching.service import (
    LaunchService,
)

__all__ = [
    'LaunchService',
]
