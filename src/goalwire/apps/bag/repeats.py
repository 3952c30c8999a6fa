"""Repeats the latest messages of topics such as /tf_static at the beginning of every file of a bag.

A reader of only one file, or of a snapshot, needs these messages, too.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Mapping

from goalwire.rosbag2.model import Message

ALWAYS = {'/tf_static': 1}
"""Topics that are always repeated, with the number of messages for each publisher."""


class Repeats:
    """Keeps the latest messages of each publisher; only the writing thread may use it."""

    def __init__(self, depths: Mapping[str, int]) -> None:
        """`depths`: the number of messages to keep, by topic. Messages of other topics are not kept."""
        self._depths = {**ALWAYS, **depths}
        self._kept: dict[tuple[str, bytes], deque[Message]] = defaultdict(deque)

    def note(self, message: Message, gid: bytes) -> None:
        """Keep a written message, if its topic is repeated."""
        depth = self._depths.get(message.topic)
        if depth is None:
            return
        kept = self._kept[message.topic, gid]
        kept.append(message)
        if len(kept) > depth:
            kept.popleft()

    def heads(self, time: int) -> list[Message]:
        """Return the repeated messages for the beginning of a file, with the time `time` in ns."""
        return [message._replace(time=time) for kept in self._kept.values() for message in kept]
