"""launch.event."""

from goalwire.launching.model import (
    Event,
)

__all__ = [
    'Event',
]
