"""launch_ros.parameters_type: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.parameters import (
    SomeParameters,
)

__all__ = [
    'SomeParameters',
]
