"""tf2_py: the buffer of transforms, which needs no node, and its exceptions."""

from goalwire.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformException,
)
from goalwire.errors import (
    TransformTimeoutException as TimeoutException,
)
from tf2_py.buffer_core import BufferCore

__all__ = [
    'BufferCore',
    'ConnectivityException',
    'ExtrapolationException',
    'InvalidArgumentException',
    'LookupException',
    'TimeoutException',
    'TransformException',
]
