"""Locks for objects that a forked child goes on using: in the child they are free, whoever held them before.

A fork copies a held lock, but not the thread that holds it: in the child no thread would ever release it. The
data that such a lock protects must be consistent after each step of a change, since the fork may come between
two steps.
"""

from __future__ import annotations

import os
from threading import RLock
from types import TracebackType
from weakref import WeakSet


class ForkableLock:
    """A re-entrant lock for `with`. In a forked child it is a new free lock, unless the forking thread itself
    held it.
    """

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
        """In a forked child, become free if a thread of the parent held this lock."""
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
