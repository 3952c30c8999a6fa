"""launch.substitution: offers the names of ROS 2's module of this name."""

from goalwire.launching.model import (
    Substitution,
)

__all__ = [
    'Substitution',
]
