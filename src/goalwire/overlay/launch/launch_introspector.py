"""launch.launch_introspector."""

from goalwire.launching.introspection import (
    LaunchIntrospector,
)

__all__ = [
    'LaunchIntrospector',
]
