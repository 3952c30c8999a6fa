"""launch.launch_description_source."""

from goalwire.launching.sources import (
    LaunchDescriptionSource,
)

__all__ = [
    'LaunchDescriptionSource',
]
