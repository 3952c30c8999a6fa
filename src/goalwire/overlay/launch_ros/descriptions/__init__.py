"""launch_ros.descriptions: offers the names of ROS 2's module of this name."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.ros.components import (
    ComposableNode,
)
from goalwire.launching.ros.parameters import (
    Parameter,
    ParameterFile,
    ParameterValue,
)

__all__ = [
    'ComposableNode',
    'Parameter',
    'ParameterFile',
    'ParameterValue',
]

add_modules(__name__)
