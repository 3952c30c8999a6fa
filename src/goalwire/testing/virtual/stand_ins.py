"""Stand-ins for Python's own clocks, sleeps, locks, threads and selectors.

Each works for any thread at any time. It behaves like the real object, except on members of a running virtual
time. So a module that keeps a stand-in after virtual time has ended does no harm.
"""

from __future__ import annotations

import os
import queue
import selectors
import threading
import time
from _thread import allocate_lock
from queue import _PySimpleQueue as PureQueue  # type: ignore[attr-defined] # made of a lock that is stood in for
from typing import TYPE_CHECKING, Any, SupportsIndex, TypeAlias, cast
from weakref import WeakKeyDictionary

from goalwire.execution.asyncio.loop_waker import WAKE_FDS
from goalwire.execution.time.steady_clock import SteadyClock
from goalwire.testing.virtual.scheduler import never

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.testing.virtual.scheduler import Child, Scheduler

Ready: TypeAlias = list[tuple[selectors.SelectorKey, int]]

REAL_LOCK = allocate_lock
_real_sleep = time.sleep
_real_start = threading.Thread.start
_real_join = threading.Thread.join
_real_is_alive = threading.Thread.is_alive
_real_select = cast(
    'Callable[[selectors.BaseSelector, float | None], Ready]', selectors.DefaultSelector.select
)

OUTSIDE = frozenset({'goalwire-signals'})
"""Names of threads that always wait in real time."""


class Running:
    """The running virtual time, if there is one."""

    scheduler: Scheduler | None = None
    epoch_ns = 0
    """System time minus steady time, in ns."""


def _reset_in_child() -> None:
    """In a forked child, forget the waiting threads: they exist only in the parent."""
    Running.scheduler = None


if hasattr(os, 'register_at_fork'):
    os.register_at_fork(after_in_child=_reset_in_child)


def _here() -> tuple[Scheduler, Child] | None:
    scheduler = Running.scheduler
    if scheduler is None:
        return None
    child = scheduler.here()
    return None if child is None else (scheduler, child)


def _deadline(scheduler: Scheduler, seconds: float) -> int:
    return scheduler.now + max(round(min(seconds, threading.TIMEOUT_MAX) * 1e9), 1 if seconds > 0 else 0)


def _time_left(scheduler: Scheduler, deadline: int) -> float:
    """Return the rest of a wait in s, for the real wait that continues it after virtual time has ended."""
    return max(deadline - scheduler.now, 0) / 1e9


# -- time


def _clock(real: Callable[[], Any], *, system: bool, nanoseconds: bool) -> Callable[[], Any]:
    def tell() -> int | float:
        scheduler = Running.scheduler
        if scheduler is None or not scheduler.holds_here():
            told: int | float = real()
            return told
        child = scheduler.here()
        now = scheduler.now if child is None else scheduler.read(child)
        if system:
            now += Running.epoch_ns
        return now if nanoseconds else now / 1e9

    tell.__name__ = tell.__qualname__ = real.__name__
    tell.__doc__ = real.__doc__
    return tell


def _whole(seconds: SupportsIndex) -> int:
    return seconds.__index__() if hasattr(seconds, '__index__') else -1


def sleep(seconds: float | SupportsIndex, /) -> None:
    """Sleep: in virtual time on a member's thread, else in real time."""
    found = _here()
    wanted = seconds if isinstance(seconds, float) else _whole(seconds)
    if found is None or wanted < 0:
        _real_sleep(seconds)  # raises the usual error if `seconds` is not a time
        return
    scheduler, child = found
    deadline = _deadline(scheduler, wanted)
    if scheduler.wait(child, never, deadline) is None:
        _real_sleep(_time_left(scheduler, deadline))


# -- locks, and what Python builds from locks: events, conditions, queues


class Lock:
    """A lock for which members wait in virtual time."""

    __slots__ = ('__weakref__', '_lock')

    def __init__(self) -> None:
        self._lock = REAL_LOCK()

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """As threading.Lock's."""
        take = self._lock.acquire
        if not blocking or (timeout < 0 and timeout != -1):
            return bool(take(blocking, timeout))
        if take(False):
            return True
        found = _here()
        if found is None:
            return bool(take(True, timeout))
        scheduler, child = found
        deadline = None if timeout == -1 else _deadline(scheduler, timeout)
        got = scheduler.wait(child, lambda: take(False), deadline)
        if got is None:
            return bool(take(True, -1 if deadline is None else _time_left(scheduler, deadline)))
        return got

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def release(self) -> None:
        """As threading.Lock's."""
        self._lock.release()

    def locked(self) -> bool:
        """As threading.Lock's."""
        return bool(self._lock.locked())

    def _at_fork_reinit(self) -> None:
        self._lock = REAL_LOCK()

    def __repr__(self) -> str:
        return f'<{"locked" if self.locked() else "unlocked"} goalwire stand-in for {self._lock!r}>'


# -- threads

_children: WeakKeyDictionary[threading.Thread, Child] = WeakKeyDictionary()


def start(thread: threading.Thread) -> None:
    """Start a thread. A thread that a member starts is a member, too, and begins when its turn comes."""
    found = _here()
    if found is None:
        _real_start(thread)
        return
    scheduler, starter = found
    starter.busy = True  # the starter waits in real time until the new thread runs
    try:
        if thread.name not in OUTSIDE:
            _enrol(thread, scheduler)
        _real_start(thread)
    except BaseException:
        if thread in _children:
            scheduler.strike(_children[thread])
        raise
    finally:
        starter.busy = False


def _enrol(thread: threading.Thread, scheduler: Scheduler) -> None:
    child = _children[thread] = scheduler.enrol(thread)
    run = thread.run

    def run_as_member() -> None:
        del thread.run
        scheduler.begin(child)
        try:
            run()
        finally:
            scheduler.end(child)

    thread.run = run_as_member  # type: ignore[method-assign]


def join(thread: threading.Thread, timeout: float | None = None) -> None:
    """Wait for a thread's end: in virtual time if both threads are members, else in real time."""
    found, child = _here(), _children.get(thread)
    if found is not None and child is not None and thread is not threading.current_thread():
        scheduler, joiner = found
        deadline = None if timeout is None else _deadline(scheduler, timeout)
        ended = scheduler.wait(joiner, lambda: child.over, deadline)
        if ended is False:
            return
        timeout = None if ended or deadline is None else _time_left(scheduler, deadline)
    _real_join(thread, timeout)


def is_alive(thread: threading.Thread) -> bool:
    """Return whether a thread runs.

    A thread without further turns counts as ended, though its real end takes a moment.
    """
    child = _children.get(thread)
    if child is not None and child.over and thread is not threading.current_thread():
        _real_join(thread)
    return _real_is_alive(thread)


# -- selectors: how asyncio's loops wait


def select(selector: selectors.BaseSelector, timeout: float | None = None) -> Ready:
    """Wait for file descriptors. If there are others than a loop's wake-up descriptor, the wait may also end
    in real time.
    """
    found = _here()
    if found is None or (timeout is not None and timeout <= 0):
        return _real_select(selector, timeout)
    scheduler, child = found
    deadline = None if timeout is None else _deadline(scheduler, timeout)
    outside = len(selector.get_map().keys() - WAKE_FDS) > 1
    if scheduler.wait(child, lambda: _is_ready(selector), deadline, outside=outside) is None:
        return _real_select(selector, None if deadline is None else _time_left(scheduler, deadline))
    return _real_select(selector, 0)


def _is_ready(selector: selectors.BaseSelector) -> bool:
    try:
        return bool(_real_select(selector, 0))
    except (OSError, ValueError):  # closed meanwhile: the real wait raises the error
        return True


def _names() -> dict[int, object]:
    """Return each stand-in under the id of the real object that it replaces in all modules."""
    clocks = {
        id(real): _clock(real, system=name.startswith('time'), nanoseconds=name.endswith('_ns'))
        for name in ('time', 'time_ns', 'monotonic', 'monotonic_ns', 'perf_counter', 'perf_counter_ns')
        for real in [getattr(time, name)]
    }
    locks = {id(real): Lock for real in (REAL_LOCK, threading.Lock)}
    return {**clocks, **locks, id(_real_sleep): sleep, id(queue.SimpleQueue): PureQueue}


NAMES = _names()


def _of_class(real: Callable[[], int]) -> object:
    """Return the stand-in for a clock that is an attribute of a class."""
    return staticmethod(cast('Callable[[], int]', NAMES[id(real)]))


ATTRIBUTES: list[tuple[object, str, object]] = [
    (threading.Thread, 'start', start),
    (threading.Thread, 'join', join),
    (threading.Thread, 'is_alive', is_alive),
    (threading, '_CRLock', None),  # without it threading.RLock() is Python code that uses a Lock
    (selectors.DefaultSelector, 'select', select),
    (SteadyClock, 'now', _of_class(SteadyClock.now)),
    (SteadyClock, 'system_now', _of_class(SteadyClock.system_now)),
]
"""The owner, the name and the stand-in of each real object that is an attribute of a class or module."""
