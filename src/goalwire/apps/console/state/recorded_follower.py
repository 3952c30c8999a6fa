"""Delivers the messages of a bag up to a time as if they arrived then, in steps forward or after a jump."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any, TypeAlias

from goalwire.apps.console.state.recording import Decoders
from goalwire.rosbag2.model import Message
from goalwire.rosbag2.reader import Reader

SECOND = 1_000_000_000
WINDOW = 10 * SECOND
"""Reading begins this many ns before the time of a jump, or earlier if a topic was silent for longer."""
_FORWARD = 20 * SECOND
"""A jump forward by at most this many ns delivers the messages in between; a longer jump skips them."""

Take: TypeAlias = Callable[[str, Any, int], object]
"""Called with a topic, its message, and the time of recording in ns since 1970."""


class Follower:
    """The messages of some topics; only for the thread that has opened the bag."""

    def __init__(
        self,
        bag: Reader,
        decoders: Decoders,
        topics: Collection[str],
        begin: Callable[[], object],
        take: Take,
        latched: Sequence[str] = (),
    ) -> None:
        """`begin` is called after each jump, before any message: it must discard the earlier state.

        After a jump, topics that are also in `latched` are replayed from the start of the bag, the
        others from the new time.
        """
        self._bag = bag
        self._decoders = decoders
        self.topics = [name for name in topics if bag.counts.get(name)]
        self._latched = [name for name in latched if name in self.topics]
        self._begin = begin
        self._take = take
        self._first: dict[str, int] = {}
        self._at: int | None = None
        self._messages: Iterator[Message] = iter(())
        self._next: Message | None = None

    def move_to(self, time: int) -> None:
        """Deliver the messages up to a time. Raises BagError for broken bytes."""
        if self._at is None or not self._at <= time <= self._at + _FORWARD:
            self._jump(time)
        self._at = time
        while self._next is not None and self._next.time <= time:
            self._hand_on(self._next)
            self._next = next(self._messages, None)

    def _jump(self, time: int) -> None:
        self._at = None  # If this jump fails, the next call jumps again.
        self._begin()
        since = min((self._since(name, time) for name in self._moving()), default=time)
        if self._latched:
            for message in self._bag.messages(self._latched, stop=since):
                self._hand_on(message)
        self._messages = self._bag.messages(self.topics, start=since) if self.topics else iter(())
        self._next = next(self._messages, None)

    def _moving(self) -> list[str]:
        return [name for name in self.topics if name not in self._latched]

    def _since(self, topic: str, time: int) -> int:
        """Return the time to read from, so that the latest message of a topic is read."""
        if topic not in self._first:
            first = next(self._bag.messages([topic]), None)
            self._first[topic] = self._bag.end if first is None else first.time
        if self._first[topic] > time:
            return time
        window = WINDOW
        while next(self._bag.messages([topic], time - window, time + 1), None) is None:
            window *= 4
        return time - window

    def _hand_on(self, message: Message) -> None:
        value = self._decoders.decode(message.topic, message.data)
        if value is not None:
            self._take(message.topic, value, message.time)
