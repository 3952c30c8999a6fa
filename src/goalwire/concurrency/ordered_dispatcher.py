"""Delivers items in order, from many threads, and no thread waits for another."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Generic, TypeVar

T = TypeVar('T')


class OrderedDispatcher(Generic[T]):
    """Hands items to `deliver` one at a time, first in first out.

    `post` first, under whatever lock decides the order; then `drain`, under none. A thread that finds
    another one draining leaves its items to it: so nobody blocks, and a `deliver` that posts to the same
    dispatcher does not recurse.
    """

    __slots__ = ('_deliver', '_items', '_turn', 'post')

    def __init__(self, deliver: Callable[[T], None]) -> None:
        self._deliver = deliver
        self._items: deque[T] = deque()
        self.post = self._items.append
        """Queue one item; nothing is delivered yet."""
        self._turn = Lock()

    def drain(self) -> None:
        """Deliver the queued items, unless another thread, or a caller further up, does so already."""
        # The outer test is repeated after the turn was given back: an item posted just before is not lost.
        items = self._items
        while items and self._turn.acquire(False):
            try:
                while items:
                    self._deliver(items.popleft())
            finally:
                self._turn.release()

    @contextmanager
    def first_turn(self) -> Iterator[None]:
        """Keep the turn of a new dispatcher; whatever was posted within is delivered when the block ends."""
        with self._turn:
            yield
            while self._items:
                self._deliver(self._items.popleft())
        self.drain()
