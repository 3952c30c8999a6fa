"""Forked children: resets the objects that a child inherits, or leaks them.

A fork copies a process's memory and descriptors, but not its threads. So in the child a lock may stay held
for ever by a thread that does not exist there, and waiting for one of the parent's threads never ends.
Sockets and epolls are shared with the parent: closing one closes only the child's copy, but other changes
affect both processes.

Another thread may open a socket at the moment of a fork. The child would have a copy that none of its objects
knows, and the other end would never see that the parent has gone. So sockets are opened by `open_privately`,
and a fork waits until a socket that is being opened is registered.

Resets are independent: if a reset fails, Python reports its exception as it does for finalizers, and the
other resets still run.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from threading import RLock
from typing import Protocol, TypeVar

from goalwire.errors import ForkedError
from goalwire.weak_members import WeakMembers


class Inherited(Protocol):
    """An object that resets itself in a forked child."""

    def reset_in_child(self) -> None:
        """Give up everything that belongs to the parent.

        Called in the child, once for each fork, before any other code.
        """


class Closable(Protocol):
    """An object with descriptors: a socket, a poller."""

    def close(self) -> None:
        """Close the descriptors, once."""


C = TypeVar('C', bound=Closable)

forks_wait = RLock()
"""Held while a private descriptor is opened, and during a fork, even for a short-lived socket.

Reentrant: a signal's handler may open or fork, too.
"""
_private: WeakMembers[Closable] = WeakMembers()
_guards: WeakMembers[ForkGuard] = WeakMembers()
_resets: list[Callable[[], None]] = []
_inherited: WeakMembers[Inherited] = WeakMembers()


def _end_fork() -> None:
    with suppress(RuntimeError):  # a signal's handler raised before the fork got the lock
        forks_wait.release()


def _in_child() -> None:
    _end_fork()
    for guard in _guards.alive():
        guard.is_forked = guard.is_silent = True
    failures = []
    closing = [each.close for each in _private.alive()]
    for reset in [*closing, *_resets, *(each.reset_in_child for each in _inherited.alive())]:
        try:
            reset()
        except Exception as error:
            failures.append(error)
    if failures:
        texts = '; '.join(f'{type(error).__name__}: {error}' for error in failures)
        raise ExceptionGroup(f'not everything could be reset in a forked child: {texts}', failures)


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(before=forks_wait.acquire, after_in_parent=_end_fork, after_in_child=_in_child)


def open_privately(open_it: Callable[[], C]) -> C:
    """Return the object that `open_it` opens. A child that is forked while the object lives closes its copy.

    `open_it` must not wait, since forks wait for its end. The object is held weakly.
    """
    with forks_wait:
        opened = open_it()
        _private.add(opened)
        return opened


def in_child(reset: Callable[[], None]) -> None:
    """Have `reset` called in every forked child, before any other code: for module-wide tables and locks."""
    _resets.append(reset)


def reset_in_children(thing: Inherited) -> None:
    """Have `thing.reset_in_child()` called in every child forked while `thing` lives. Held weakly."""
    _inherited.add(thing)


def leak(thing: object) -> None:
    """Keep an object for ever, past the interpreter's end: freeing it in a forked child could hang."""
    from ctypes import py_object, pythonapi

    pythonapi.Py_IncRef(py_object(thing))


class ForkGuard:
    """Remembers the process that opened something; `is_forked` is True in a child forked since."""

    __slots__ = ('__weakref__', 'is_forked', 'is_silent')

    def __init__(self) -> None:
        self.is_forked = False
        self.is_silent = False
        """True if publishers and clients must not send: after `silence`, and in a forked child."""
        _guards.add(self)

    def silence(self) -> None:
        """Refuse to send from now on. Takes no lock: any thread and signal handlers may call it."""
        self.is_silent = True

    def check(self, what: str) -> None:
        """Raise ForkedError in a child; `what` names the thing that was used."""
        if self.is_forked:
            raise ForkedError(
                f'{what} was opened before this process was forked and is dead in the child; '
                f'open a new context in the child, or start it with the spawn method of multiprocessing'
            )
