"""launch_ros.parameters_type: the names of ROS 2's module."""

from goalwire.launching.ros.parameters import (
    SomeParameters,
)

__all__ = [
    'SomeParameters',
]
