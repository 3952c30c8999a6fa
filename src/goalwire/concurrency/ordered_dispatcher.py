"""Delivers items of many threads in order, without one thread waiting for another."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Generic, TypeVar

T = TypeVar('T')


class OrderedDispatcher(Generic[T]):
    """Hands items to `deliver` one at a time, first in first out.

    `on_error` gets the errors of `deliver`; without it they come out of `drain`.

    Call `post` under the lock that decides the order, then `drain` without any lock. If another thread is
    already draining, it delivers the new items, too. So no thread blocks, and a `deliver` that posts to the
    same dispatcher does not recurse.
    """

    __slots__ = ('_deliver', '_on_error', '_turn', 'items', 'post')

    def __init__(
        self, deliver: Callable[[T], object], on_error: Callable[[Exception], object] | None = None
    ) -> None:
        self._deliver = deliver
        self._on_error = on_error
        self.items: deque[T] = deque()
        """The queued items."""
        self.post = self.items.append
        """Queue one item; nothing is delivered yet."""
        self._turn = Lock()

    def drain(self) -> None:
        """Deliver the queued items, unless another thread or an outer call already does."""
        # The outer test is repeated after the turn is given back: else an item posted just before would stay.
        items = self.items
        while items and self._turn.acquire(False):
            try:
                while items:
                    self._deliver(items.popleft())
            except Exception as error:
                if self._on_error is None:
                    raise
                self._on_error(error)
            finally:
                self._turn.release()

    @contextmanager
    def first_turn(self) -> Iterator[None]:
        """Hold deliveries back within a `with` block; items posted meanwhile are delivered at its end."""
        with self._turn:
            yield
            while self.items:
                self._deliver(self.items.popleft())
        self.drain()
