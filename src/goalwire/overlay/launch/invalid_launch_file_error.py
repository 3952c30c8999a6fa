"""launch.invalid_launch_file_error."""

from goalwire.errors import InvalidLaunchFileError

__all__ = [
    'InvalidLaunchFileError',
]
