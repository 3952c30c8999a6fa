"""launch.frontend.parser."""

from goalwire.errors import InvalidFrontendLaunchFileError
from goalwire.launching.frontend import (
    Parser,
)

__all__ = [
    'InvalidFrontendLaunchFileError',
    'Parser',
]
