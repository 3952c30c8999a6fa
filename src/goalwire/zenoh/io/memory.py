"""Large messages leave free memory behind: when the allocator keeps it, and when it gives it back.

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
    """Have the allocator return the memory of large messages that were never completed; only glibc can."""
    if sys.platform != 'linux':
        return
    import ctypes

    with suppress(OSError, AttributeError):  # not glibc
        ctypes.CDLL(None).malloc_trim(0)


def keep_freed_memory() -> None:
    """Have the allocator keep the memory of large messages for the next ones.

    Once in a process; only glibc can.
    """
    if _done:
        return
    _done.append(True)
    if sys.platform != 'linux' or any(name in os.environ for name in _VARIABLES):
        return
    import ctypes

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):  # not glibc
        return
    mallopt(_TRIM_THRESHOLD, _KEPT)
    mallopt(_MMAP_THRESHOLD, _FROM_THE_SYSTEM)
