"""A filter that keeps a history of messages."""

from __future__ import annotations

from collections import deque
from typing import Any

from rclpy.time import Time

from goalwire.concurrency.snapshots import copy_of
from message_filters.simple_filter import SimpleFilter
from message_filters.stamps import stamp_or_arrival

__all__ = ['Cache']


class Cache(SimpleFilter):
    """Keeps the last `cache_size` messages of its input, and passes every message on."""

    def __init__(self, f: SimpleFilter, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size = cache_size
        self.allow_headerless = allow_headerless
        self._entries: deque[tuple[Time, Any]] = deque(maxlen=cache_size)  # messages in the order of arrival
        self.connectInput(f)

    @property
    def cache_msgs(self) -> list[Any]:
        """The messages, in the order of their arrival."""
        return [msg for _, msg in copy_of(self._entries)]

    @property
    def cache_times(self) -> list[Time]:
        """The stamps of the kept messages."""
        return [stamp for stamp, _ in copy_of(self._entries)]

    def connectInput(self, f: SimpleFilter) -> None:
        """Take the output of the filter `f` as input."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Keep a message and pass it on. A full cache drops its oldest message."""
        stamp = stamp_or_arrival(
            msg, allow_headerless=self.allow_headerless, logger_name='message_filters_cache'
        )
        if stamp is not None:
            self._entries.append((stamp, msg))
            self.signalMessage(msg)

    def getInterval(self, from_stamp: Time, to_stamp: Time) -> list[Any]:
        """Return the messages in a closed interval; raises AssertionError if its ends are reversed."""
        if from_stamp > to_stamp:
            raise AssertionError(f'the interval is reversed: from {from_stamp} to {to_stamp}')
        return [msg for stamp, msg in copy_of(self._entries) if from_stamp <= stamp <= to_stamp]

    def getElemAfterTime(self, stamp: Time) -> Any:
        """Return the first kept message at or after an instant; None if there is no such message."""
        return next((msg for own, msg in copy_of(self._entries) if own >= stamp), None)

    def getElemBeforeTime(self, stamp: Time) -> Any:
        """Return the last kept message at or before an instant; None if there is no such message."""
        return next((msg for own, msg in reversed(copy_of(self._entries)) if own <= stamp), None)

    def getLastestTime(self) -> Time | None:
        """Return the stamp of the message that came last; None without messages.

        The misspelt name is ROS 2's.
        """
        return self._entries[-1][0] if self._entries else None

    def getLatestTime(self) -> Time | None:
        """Return the same as getLastestTime."""
        return self.getLastestTime()

    def getOldestTime(self) -> Time | None:
        """Return the stamp of the kept message that came first; None without messages."""
        return self._entries[0][0] if self._entries else None

    def getLast(self) -> Any:
        """Return the message that came last; None without messages."""
        return self._entries[-1][1] if self._entries else None
