"""launch.frontend.expose: offers the names of ROS 2's module of this name."""

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
