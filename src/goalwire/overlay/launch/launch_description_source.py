"""launch.launch_description_source: the names of ROS 2's module."""

from goalwire.launching.sources import (
    LaunchDescriptionSource,
)

__all__ = [
    'LaunchDescriptionSource',
]
