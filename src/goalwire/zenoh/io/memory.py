"""Large messages and the allocator.

glibc gives the memory of a freed message of 1 MB back to the system, and takes it anew, page by page, for the
next one. On a virtual machine that costs some 5 µs a page: an image of 1 MB took 3.4-9 ms from publisher to
acknowledgement, and takes 0.5-0.8 ms where the allocator keeps 64 MiB. So it is told to, with the first large
message of a process. Whoever sets MALLOC_TRIM_THRESHOLD_ or MALLOC_MMAP_THRESHOLD_ decides otherwise.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress

_KEPT = 64 << 20
_FROM_THE_SYSTEM = 32 << 20
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
_VARIABLES = ('MALLOC_TRIM_THRESHOLD_', 'MALLOC_MMAP_THRESHOLD_', 'GLIBC_TUNABLES')
_done: list[bool] = []


MUCH = 16 << 20
"""Bytes of thrown away pieces from which it pays to return them: to look for free pages takes
milliseconds."""


def return_freed_memory() -> None:
    """Have the allocator give back what is left of large messages that never became whole; only glibc
    does."""
    if sys.platform != 'linux':
        return
    import ctypes

    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


def keep_freed_memory() -> None:
    """Have the allocator keep what large messages have left, once in a process; nothing without glibc."""
    if _done:
        return
    _done.append(True)
    if sys.platform != 'linux' or any(name in os.environ for name in _VARIABLES):
        return
    import ctypes

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):  # another C library
        return
    mallopt(_TRIM_THRESHOLD, _KEPT)
    mallopt(_MMAP_THRESHOLD, _FROM_THE_SYSTEM)
