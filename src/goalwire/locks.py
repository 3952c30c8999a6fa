"""Locks of things that a forked child goes on using: it finds them free, whoever held them in the parent.

A fork copies a lock as it is, but not the thread that holds it: in the child nobody would ever release it.
The data behind such a lock must be whole at each step, since the child may find it between two of them.
"""

from __future__ import annotations

import os
from threading import RLock
from types import TracebackType
from weakref import WeakSet


class ForkableLock:
    """A re-entrant lock for `with`. In a forked child it is new, unless the forking thread itself held it."""

    __slots__ = ('__weakref__', '_lock')

    def __init__(self) -> None:
        self._lock = RLock()
        _locks.add(self)

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._lock.release()

    def renew_in_child(self) -> None:
        """In a forked child: be free, if a thread that is not there holds this."""
        if self._lock.acquire(blocking=False):
            self._lock.release()
        else:
            self._lock = RLock()


_locks: WeakSet[ForkableLock] = WeakSet()


def _renew_all() -> None:
    for lock in list(_locks):
        lock.renew_in_child()


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_renew_all)
