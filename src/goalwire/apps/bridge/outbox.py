"""The queue of messages to one client. If the client is too slow, messages of topics are dropped."""

from __future__ import annotations

import asyncio
from collections import Counter, deque
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

Frame: TypeAlias = str | bytes


class Connection(Protocol):
    """A web socket."""

    async def send(self, message: Frame, /) -> None:
        """Send one message; wait while the client does not read."""


class _Item(NamedTuple):
    frames: Sequence[Frame]
    size: int
    topic: str | None


class Outbox:
    """A queue of up to `limit` bytes. Beyond the limit the oldest topic message is dropped and counted.

    Answers are never dropped. If the client does not read and the answers alone exceed the limit,
    `on_overflow` is called, which must end the connection.
    """

    def __init__(self, limit: int, on_overflow: Callable[[], object]) -> None:
        self._limit = limit
        self._on_overflow = on_overflow
        self._items: dict[int, _Item] = {}
        """The waiting messages by serial number, the oldest first."""
        self._droppable: deque[int] = deque()
        """The keys of topic messages in `_items`; keys of messages that were sent may remain."""
        self._of_topic: dict[str, deque[int]] = {}
        self._count = 0
        self._held = 0
        self._filled = asyncio.Event()
        self.dropped: Counter[str] = Counter()
        """How many messages were dropped, by topic."""

    def put(self, frames: Sequence[Frame]) -> None:
        """Add an answer, which is never dropped."""
        self._add(frames, None)

    def put_of_topic(self, topic: str, frames: Sequence[Frame], most: int = 0) -> None:
        """Add a topic's message. At most `most` messages of the topic wait; 0: as many as the queue holds."""
        self._add(frames, topic)
        waiting = self._of_topic.get(topic)
        while most and waiting is not None and len(waiting) > most:
            self._drop(waiting[0])

    def _add(self, frames: Sequence[Frame], topic: str | None) -> None:
        size = sum(map(len, frames))
        self._count += 1
        self._items[self._count] = _Item(frames, size, topic)
        self._held += size
        if topic is not None:
            self._droppable.append(self._count)
            self._of_topic.setdefault(topic, deque()).append(self._count)
        while self._held > self._limit and self._droppable:
            self._drop(self._droppable.popleft())
        self._filled.set()
        if self._held > self._limit and len(self._items) > 1:
            self._on_overflow()

    def _drop(self, number: int) -> None:
        item = self._take(number)
        if item is not None and item.topic is not None:
            self.dropped[item.topic] += 1

    def _take(self, number: int) -> _Item | None:
        item = self._items.pop(number, None)
        if item is None:
            return None
        self._held -= item.size
        if item.topic is not None:
            waiting = self._of_topic[item.topic]
            waiting.remove(number)  # fast: the message is usually the topic's oldest, at the front
            if not waiting:
                del self._of_topic[item.topic]
        while self._droppable and self._droppable[0] not in self._items:
            self._droppable.popleft()
        return item

    async def send_all(self, connection: Connection) -> None:
        """Send the messages one after the other, until cancelled or until the connection ends."""
        while True:
            while self._items:
                item = self._take(next(iter(self._items)))
                assert item is not None
                for frame in item.frames:
                    await connection.send(frame)
            self._filled.clear()
            await self._filled.wait()
