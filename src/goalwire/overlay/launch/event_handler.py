"""launch.event_handler."""

from goalwire.launching.model import (
    EventHandler,
)

__all__ = [
    'EventHandler',
]
