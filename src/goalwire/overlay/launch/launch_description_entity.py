"""launch.launch_description_entity."""

from goalwire.launching.model import (
    LaunchDescriptionEntity,
)

__all__ = [
    'LaunchDescriptionEntity',
]
