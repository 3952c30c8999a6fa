"""launch.action."""

from goalwire.launching.model import (
    Action,
)

__all__ = [
    'Action',
]
