"""launch.substitution."""

from goalwire.launching.model import (
    Substitution,
)

__all__ = [
    'Substitution',
]
