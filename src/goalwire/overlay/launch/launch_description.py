"""launch.launch_description."""

from goalwire.launching.model import (
    LaunchDescription,
)

__all__ = [
    'LaunchDescription',
]
