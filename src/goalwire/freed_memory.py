"""Tells the allocator when to keep the memory of large messages, and when to return it to the system.

glibc gives the memory of a freed message of 1 MB back to the system, and requests it anew, page by page, for
the next message. On a virtual machine that costs some 5 µs a page: an image of 1 MB took 3.4-9 ms from
publisher to acknowledgement, and takes 0.5-0.8 ms if the allocator keeps 64 MiB. So the first large message
of a process makes the allocator keep 64 MiB. MALLOC_TRIM_THRESHOLD_ and MALLOC_MMAP_THRESHOLD_ in the
environment override it.
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


LARGE = 1 << 17
"""The size of a payload, in bytes, from which the allocator keeps freed memory for the next one."""
MUCH = 16 << 20
"""The number of discarded bytes from which their return to the system is worth the milliseconds that it
takes.
"""


def return_freed_memory() -> None:
    """Have the allocator return the memory of large messages that were never completed. Only glibc supports
    this.
    """
    if sys.platform != 'linux':
        return
    import ctypes

    with suppress(OSError, AttributeError):  # not glibc
        ctypes.CDLL(None).malloc_trim(0)


def keep_freed_memory() -> None:
    """Have the allocator keep the memory of large messages for the next ones.

    Only the first call in a process has an effect, and only with glibc.
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
