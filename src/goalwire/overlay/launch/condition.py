"""launch.condition."""

from goalwire.launching.model import (
    Condition,
)

__all__ = [
    'Condition',
]
