"""launch.invalid_launch_file_error: the names of ROS 2's module."""

from goalwire.errors import InvalidLaunchFileError

__all__ = [
    'InvalidLaunchFileError',
]
