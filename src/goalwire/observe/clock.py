"""Converts times: observers keep readings of the monotonic clock, so ages stay right if the wall clock is
set.

Stamps of messages are times of the wall clock, in s since 1970. `wall_offset` converts one to the other; it
is read when a time is shown, so that the time of day follows the present wall clock.
"""

from __future__ import annotations

from time import localtime, monotonic, strftime, time


def wall_offset() -> float:
    """Return the seconds to add to a reading of the monotonic clock, which gives a time in s since 1970."""
    return time() - monotonic()


def time_of_day(reading: float) -> str:
    """Return a reading of the monotonic clock as hours, minutes and seconds of local time."""
    return local_time(reading + wall_offset())


def local_time(stamp: float) -> str:
    """Return a time in s since 1970 as hours, minutes and seconds of local time."""
    return strftime('%H:%M:%S', localtime(stamp))
