"""The latest messages of topics that every file of a bag begins with, such as /tf_static.

A reader of one file, or of a snapshot, needs them as much as a reader of the whole bag.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Mapping

from goalwire.rosbag2.model import Message

ALWAYS = {'/tf_static': 1}
"""Topics that are repeated without being asked for, and how many messages of each publisher."""


class Repeats:
    """Keeps the latest messages of each publisher; only the writing thread may use it."""

    def __init__(self, depths: Mapping[str, int]) -> None:
        """Keep as many messages of each topic as `depths` says; of others none."""
        self._depths = {**ALWAYS, **depths}
        self._kept: dict[tuple[str, bytes], deque[Message]] = defaultdict(deque)

    def note(self, message: Message, gid: bytes) -> None:
        """Keep a message that was written, if its topic is one of these."""
        depth = self._depths.get(message.topic)
        if depth is None:
            return
        kept = self._kept[message.topic, gid]
        kept.append(message)
        if len(kept) > depth:
            kept.popleft()

    def heads(self, time: int) -> list[Message]:
        """Return what a file begins with that begins at `time`, in ns."""
        return [message._replace(time=time) for kept in self._kept.values() for message in kept]
