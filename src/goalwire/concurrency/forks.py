"""What a forked child does with what it has inherited: it knows of it, resets it, or leaks it.

A fork copies a process's memory, but not its threads. So in the child a lock may be held for ever, by a
thread that is not there, and whoever waits for one of the parent's threads waits for ever.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from weakref import WeakSet

from goalwire.errors import ForkedError

_guards: WeakSet[ForkGuard] = WeakSet()
_resets: list[Callable[[], None]] = []


def _in_child() -> None:
    for guard in _guards:
        guard.is_forked = guard.is_silent = True
    for reset in _resets:
        reset()


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_in_child)


def in_child(reset: Callable[[], None]) -> None:
    """Have `reset` called in every forked child, before any other code: for module-wide tables and locks."""
    _resets.append(reset)


def leak(thing: object) -> None:
    """Keep a thing for ever, past the interpreter's end: dropping it in a forked child could hang."""
    from ctypes import py_object, pythonapi

    pythonapi.Py_IncRef(py_object(thing))


class ForkGuard:
    """Remembers in which process something was opened; `is_forked` is True in a child forked since."""

    __slots__ = ('__weakref__', 'is_forked', 'is_silent')

    def __init__(self) -> None:
        self.is_forked = False
        self.is_silent = False
        """True where publishers and clients send nothing more: after `silence`, and in a forked child."""
        _guards.add(self)

    def silence(self) -> None:
        """Have publishers and clients send nothing more. Any thread, signal handlers too; takes no lock."""
        self.is_silent = True

    def check(self, what: str) -> None:
        """Raise ForkedError in a child; `what` names the thing that was used."""
        if self.is_forked:
            raise ForkedError(
                f'{what} was opened before this process was forked and is dead in the child; '
                f'open a new context in the child, or start it with the spawn method of multiprocessing'
            )
