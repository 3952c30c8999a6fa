"""Listeners that are held weakly: any thread adds and removes them, without a lock."""

from __future__ import annotations

from typing import TypeVar
from weakref import ReferenceType, ref

L = TypeVar('L')


class WeakListeners(dict[ReferenceType[L], None]):
    """Listeners, held weakly, in the order in which they were added.

    Any thread may add and discard, also while others go through them: each step is one operation of a dict or
    of a list. The callback of a dead reference is a method of a list, too. In a function of Python, a signal
    handler could raise, as Python's own does for Ctrl-C. Python prints such an error and loses it.
    """

    __slots__ = ('_dead',)

    def __init__(self) -> None:
        super().__init__()
        self._dead: list[ReferenceType[L]] = []
        """The references whose listeners have died. `add` and `alive` remove them."""

    def add(self, listener: L) -> None:
        """Add a listener. Adding it twice is harmless."""
        if self._dead:
            self._remove_dead()
        self[ref(listener, self._dead.append)] = None

    def discard(self, listener: L) -> None:
        """Remove a listener; nothing happens if it is not there."""
        self.pop(ref(listener), None)

    def alive(self) -> list[L]:
        """Return the listeners that still live."""
        if self._dead:
            self._remove_dead()
        # A list and not a tuple: Python 3.11 may collect garbage while it makes a tuple, which changes the
        # dict.
        found = []
        for reference in list(self):
            listener = reference()
            if listener is not None:
                found.append(listener)
        return found

    def _remove_dead(self) -> None:
        dead = self._dead
        while dead:
            try:
                self.pop(dead.pop(), None)
            except IndexError:
                return  # another thread has removed the last one
