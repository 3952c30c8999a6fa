"""launch.launch_introspector: offers the names of ROS 2's module of this name."""

from goalwire.launching.introspection import (
    LaunchIntrospector,
)

__all__ = [
    'LaunchIntrospector',
]
