"""launch.launch_context."""

from goalwire.launching.model import (
    LaunchContext,
)

__all__ = [
    'LaunchContext',
]
