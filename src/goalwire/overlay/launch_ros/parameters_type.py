"""launch_ros.parameters_type."""

from goalwire.launching.ros.parameters import (
    SomeParameters,
)

__all__ = [
    'SomeParameters',
]
