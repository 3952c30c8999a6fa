"""launch.frontend.parser: offers the names of ROS 2's module of this name."""

from goalwire.errors import InvalidFrontendLaunchFileError
from goalwire.launching.frontend import (
    Parser,
)

__all__ = [
    'InvalidFrontendLaunchFileError',
    'Parser',
]
