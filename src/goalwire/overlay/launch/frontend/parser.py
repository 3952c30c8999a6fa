"""launch.frontend.parser."""

from goalwire.launching.frontend import (
    InvalidFrontendLaunchFileError,
    Parser,
)

__all__ = [
    'InvalidFrontendLaunchFileError',
    'Parser',
]
