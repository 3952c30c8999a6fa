"""launch.launch_description_source: offers the names of ROS 2's module of this name."""

from goalwire.launching.sources import (
    LaunchDescriptionSource,
)

__all__ = [
    'LaunchDescriptionSource',
]
