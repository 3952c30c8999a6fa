"""The samples that a writer keeps, for readers that lack them."""

from __future__ import annotations

from collections import deque


class Change:
    """A change in a writer's history: a sample, or the disposal or unregistration of an instance."""

    __slots__ = ('fragment_size', 'is_key', 'key', 'number', 'payload', 'qos', 'reader', 'size', 'time')

    def __init__(
        self,
        number: int,
        time: int,
        payload: bytes | None,
        qos: bytes = b'',
        reader: bytes | None = None,
        key: bytes = b'',
        is_key: bool = False,
    ) -> None:
        self.number = number
        self.time = time
        """The source timestamp, in nanoseconds since 1970."""
        self.payload = payload
        """The encapsulated sample, or key."""
        self.size = len(payload) if payload else 0
        """Bytes of the payload."""
        self.qos = qos
        """Inline QoS with its sentinel; empty: none."""
        self.reader = reader
        """The GUID of the only reader that gets it; None: all readers get it."""
        self.key = key
        """The key of the instance, on a topic with keys. An older change with the same key is obsolete."""
        self.is_key = is_key
        self.fragment_size = 0
        """The size of its fragments; 0 if it is sent as a whole."""


class HistoryCache:
    """The changes that a writer keeps, by number."""

    def __init__(self, depth: int, *, is_keyed: bool = False) -> None:
        """Keep the last `depth` changes; 0: all. On a topic with keys, keep one change for each key."""
        self.changes: dict[int, Change] = {}
        self.size = 0
        """Bytes of all payloads."""
        self._depth = depth
        self._by_key: dict[bytes, int] | None = {} if is_keyed else None
        self._gone: deque[int] = deque()
        """The changes that dispose of or unregister an instance."""

    def add(self, change: Change) -> None:
        """Keep a change, and drop the changes that it makes obsolete."""
        changes = self.changes
        if self._by_key is not None:
            self.remove(self._by_key.get(change.key, 0))
            self._by_key[change.key] = change.number
        elif self._depth and len(changes) >= self._depth:
            self.size -= changes.pop(next(iter(changes))).size
        if change.is_key:
            self._gone.append(change.number)
        changes[change.number] = change
        self.size += change.size

    def remove(self, number: int) -> None:
        """Drop a change, if it is kept."""
        change = self.changes.pop(number, None)
        if change is not None:
            self.size -= change.size
            if self._by_key is not None and self._by_key.get(change.key) == number:
                del self._by_key[change.key]

    def remove_up_to(self, number: int) -> None:
        """Drop all changes up to `number`."""
        changes = self.changes
        if self._by_key is None:  # hot path: the body of `remove`, which saves a call for each sample
            while changes and (first := next(iter(changes))) <= number:
                self.size -= changes.pop(first).size
            return
        while changes and (first := next(iter(changes))) <= number:
            self.remove(first)

    def forget_gone(self, number: int) -> None:
        """Drop changes up to `number` that dispose of or unregister an instance: new readers need none."""
        while self._gone and self._gone[0] <= number:
            self.remove(self._gone.popleft())

    def expire(self, before: int) -> None:
        """Drop the changes that were written before the time `before`."""
        while self.changes and self.changes[first := next(iter(self.changes))].time < before:
            self.remove(first)

    def first(self, last: int) -> int:
        """Return the lowest number that is kept; `last` + 1 if nothing is kept."""
        return next(iter(self.changes), last + 1)
