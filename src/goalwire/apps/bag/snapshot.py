"""Keeps the latest messages in memory until a snapshot is requested."""

from __future__ import annotations

from collections import deque

from goalwire.rosbag2.model import Message
from goalwire.rosbag2.writer import Writer


class Snapshot:
    """A sink that keeps the newest messages, within bounds of bytes and of time, and writes them on request.

    Only the writing thread may use it.
    """

    def __init__(self, bag: Writer, limit: int, duration_ns: int = 0) -> None:
        """Keep up to `limit` bytes, for at most `duration_ns` if that is not 0."""
        self._bag = bag
        self._limit = limit
        self._duration = duration_ns
        self._kept: deque[Message] = deque()
        self._held = 0

    def put(self, message: Message) -> None:
        """Keep a message, and drop the oldest ones if the bounds are exceeded."""
        kept = self._kept
        kept.append(message)
        self._held += len(message.data)
        oldest = message.time - self._duration if self._duration else 0
        while len(kept) > 1 and (self._held > self._limit or kept[0].time < oldest):
            self._held -= len(kept.popleft().data)

    def flush(self) -> None:
        """Do nothing: messages are only written by `write`."""

    def sync(self) -> None:
        """Force the written data to the disk."""
        self._bag.sync()

    def write(self) -> int:
        """Write the kept messages into a file of their own, and forget them; return their number."""
        kept, self._kept, self._held = self._kept, deque(), 0
        if kept:
            if self._bag.count:
                self._bag.split(kept[0].time)
            elif self._bag.heads is not None:
                for head in self._bag.heads(kept[0].time):
                    self._bag.put(head)
        for message in kept:
            self._bag.put(message)
        self._bag.flush()
        return len(kept)
