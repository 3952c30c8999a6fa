"""launch_ros.parameter_descriptions: offers the names of ROS 2's module of this name."""

from goalwire.launching.ros.parameters import (
    Parameter,
    ParameterFile,
    ParameterValue,
)

__all__ = [
    'Parameter',
    'ParameterFile',
    'ParameterValue',
]
