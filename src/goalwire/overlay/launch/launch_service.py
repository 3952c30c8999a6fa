"""launch.launch_service."""

from goalwire.launching.service import (
    LaunchService,
)

__all__ = [
    'LaunchService',
]
