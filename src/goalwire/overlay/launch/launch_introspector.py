"""launch.launch_introspector: the names of ROS 2's module."""

from goalwire.launching.introspection import (
    LaunchIntrospector,
)

__all__ = [
    'LaunchIntrospector',
]
