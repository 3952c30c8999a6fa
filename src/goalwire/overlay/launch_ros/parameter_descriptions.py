"""launch_ros.parameter_descriptions: the names of ROS 2's module."""

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
