"""Locks for objects that a forked child goes on using: in the child they are free, whoever held them before.

A fork copies a held lock, but not the thread that holds it: in the child no thread would ever release it. The
data that such a lock protects must be consistent after each step of a change, since the fork may come between
two steps.
"""

from __future__ import annotations

import os
from _thread import RLock

from goalwire.weak_members import WeakMembers


class ForkableLock(RLock):  # type: ignore[misc]  # final in mypy's stubs, and not in Python
    """A re-entrant lock for `with`. In a forked child it is a new free lock, unless the forking thread itself
    held it.

    It inherits `__enter__`, which is written in C. In an `__enter__` of Python's, a signal handler could
    raise after the lock was taken, and nobody would release it.
    """

    __slots__ = ()

    def __init__(self) -> None:
        _locks.add(self)

    def renew_in_child(self) -> None:
        """In a forked child, become free if a thread of the parent held this lock."""
        if self.acquire(blocking=False):
            self.release()
        else:
            self._at_fork_reinit()  # type: ignore[attr-defined]  # as the standard library renews its own locks


_locks: WeakMembers[ForkableLock] = WeakMembers()


def _renew_all() -> None:
    for lock in _locks.alive():
        lock.renew_in_child()


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_renew_all)
