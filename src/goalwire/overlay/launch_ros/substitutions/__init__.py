"""launch_ros.substitutions: substitutions that find packages and the programs of packages."""

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
