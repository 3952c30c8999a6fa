"""The latest messages of topics such as /tf_static, which every file of a bag begins with.

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
        """`depths` says how many messages of each topic are kept; of other topics none."""
        self._depths = {**ALWAYS, **depths}
        self._kept: dict[tuple[str, bytes], deque[Message]] = defaultdict(deque)

    def note(self, message: Message, gid: bytes) -> None:
        """Keep a written message, if its topic is one of these."""
        depth = self._depths.get(message.topic)
        if depth is None:
            return
        kept = self._kept[message.topic, gid]
        kept.append(message)
        if len(kept) > depth:
            kept.popleft()

    def heads(self, time: int) -> list[Message]:
        """Return the messages with which a file begins that starts at `time`, in ns."""
        return [message._replace(time=time) for kept in self._kept.values() for message in kept]
