"""launch_ros.substitutions: packages and their programs."""

from goalwire.launching.aliases import add_modules
from goalwire.launching.ros.substitutions import (
    ExecutableInPackage,
    FindPackage,
    FindPackagePrefix,
    FindPackageShare,
    Parameter,
)

__all__ = [
    'ExecutableInPackage',
    'FindPackage',
    'FindPackagePrefix',
    'FindPackageShare',
    'Parameter',
]

add_modules(__name__)
