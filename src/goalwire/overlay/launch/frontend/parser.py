"""launch.frontend.parser: the names of ROS 2's module."""

from goalwire.errors import InvalidFrontendLaunchFileError
from goalwire.launching.frontend import (
    Parser,
)

__all__ = [
    'InvalidFrontendLaunchFileError',
    'Parser',
]
