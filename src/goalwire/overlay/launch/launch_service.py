"""launch.launch_service: offers the names of ROS 2's module of this name."""

from goalwire.launching.service import (
    LaunchService,
)

__all__ = [
    'LaunchService',
]
