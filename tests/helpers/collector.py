"""A place where threads put things and a test waits for them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from helpers.patience import PATIENCE

T = TypeVar('T')

_TOLD = 5
"""The number of the last items that a failure shows."""


class Collector(Generic[T]):
    """A list that can be waited on; an instance is itself the callback that fills it."""

    def __init__(self) -> None:
        self._items: list[T] = []
        self._threads: list[int] = []
        self._changed = threading.Condition()

    def __call__(self, item: T) -> None:
        with self._changed:
            self._items.append(item)
            self._threads.append(threading.get_ident())
            self._changed.notify_all()

    @property
    def items(self) -> list[T]:
        """The items that have come so far, in order."""
        with self._changed:
            return list(self._items)

    @property
    def threads(self) -> list[int]:
        """The identifier of the thread that brought each item."""
        with self._changed:
            return list(self._threads)

    def expect(self, number: int = 1, timeout: float = PATIENCE) -> list[T]:
        """Wait until `number` items or more have come and return all."""
        with self._changed:
            came = self._changed.wait_for(lambda: len(self._items) >= number, timeout)
            assert came, f'{len(self._items)} of {number} came within {timeout} s: {self._tell()}'
            return list(self._items)

    def wait_for(self, predicate: Callable[[list[T]], bool], timeout: float = PATIENCE) -> list[T]:
        """Wait until what has come is as `predicate` wants it, and return it."""
        with self._changed:
            came = self._changed.wait_for(lambda: predicate(self._items), timeout)
            assert came, f'not as wanted within {timeout} s: {self._tell()}'
            return list(self._items)

    def _tell(self) -> str:
        return ('…, ' if len(self._items) > _TOLD else '') + ', '.join(map(repr, self._items[-_TOLD:]))
