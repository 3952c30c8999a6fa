"""launch.invalid_launch_file_error: offers the names of ROS 2's module of this name."""

from goalwire.errors import InvalidLaunchFileError

__all__ = [
    'InvalidLaunchFileError',
]
