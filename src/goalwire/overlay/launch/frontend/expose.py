"""launch.frontend.expose: the names of ROS 2's module."""

from goalwire.launching.exposure import (
    expose_action,
    expose_substitution,
    instantiate_action,
    instantiate_substitution,
)

__all__ = [
    'expose_action',
    'expose_substitution',
    'instantiate_action',
    'instantiate_substitution',
]
