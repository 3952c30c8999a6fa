"""launch.launch_description_entity: the names of ROS 2's module."""

from goalwire.launching.model import (
    LaunchDescriptionEntity,
)

__all__ = [
    'LaunchDescriptionEntity',
]
