"""launch_ros.parameter_descriptions."""

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
