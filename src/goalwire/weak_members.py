"""Members that are held weakly: any thread adds and removes them, without a lock.

In a WeakSet, a function of Python removes a member that dies. A signal handler may raise in such a function,
as Python's own does for Ctrl-C. Python prints that error and loses it, and the program goes on.
"""

from __future__ import annotations

from typing import TypeVar
from weakref import ReferenceType, ref

M = TypeVar('M')


class WeakMembers(dict[ReferenceType[M], None]):
    """Members, held weakly, in the order in which they were added.

    Any thread may add and discard, also while others go through them: each step is one operation of a dict or
    of a list. The callback of a dead reference is a method of a list, too, so no signal handler runs in it.
    """

    __slots__ = ('_dead',)

    def __init__(self) -> None:
        super().__init__()
        self._dead: list[ReferenceType[M]] = []
        """The references whose members have died. `add` and `alive` remove them."""

    def add(self, member: M) -> None:
        """Add a member. Adding it twice is harmless."""
        if self._dead:
            self._remove_dead()
        self[ref(member, self._dead.append)] = None

    def discard(self, member: M) -> None:
        """Remove a member; nothing happens if it is not there."""
        self.pop(ref(member), None)

    def alive(self) -> list[M]:
        """Return the members that still live."""
        if self._dead:
            self._remove_dead()
        # A list and not a tuple: Python 3.11 may collect garbage while it makes a tuple, which changes the
        # dict.
        found = []
        for reference in list(self):
            member = reference()
            if member is not None:
                found.append(member)
        return found

    def _remove_dead(self) -> None:
        dead = self._dead
        while dead:
            try:
                self.pop(dead.pop(), None)
            except IndexError:
                return  # another thread has removed the last one
