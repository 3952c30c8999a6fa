"""launch.substitution: the names of ROS 2's module."""

from goalwire.launching.model import (
    Substitution,
)

__all__ = [
    'Substitution',
]
