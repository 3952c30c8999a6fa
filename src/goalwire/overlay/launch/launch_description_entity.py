"""launch.launch_description_entity: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    LaunchDescriptionEntity,
)

__all__ = [
    'LaunchDescriptionEntity',
]
