"""launch.invalid_launch_file_error."""

from goalwire.launching.errors import (
    InvalidLaunchFileError,
)

__all__ = [
    'InvalidLaunchFileError',
]
