"""The scheduler of virtual time: one thread at a time runs, and time passes when none can run.

A member is a thread that lives in virtual time. It runs until it waits. Then the next member runs: of those
whose wait is over, the one that has waited longest. If there is none, time jumps to the earliest deadline. So
the same program takes the same turns each time, and no wait takes any real time.
"""

from __future__ import annotations

from _thread import allocate_lock, get_ident
from typing import TYPE_CHECKING

from goalwire.errors import DeadlockError
from goalwire.testing.virtual.deadlock import describe, describe_stall

if TYPE_CHECKING:
    from collections.abc import Callable
    from threading import Thread

_POLLS = 1000
"""How many times in a row a thread may read the clock before it counts as waiting for time to pass."""

_NAP_NS = 10_000_000
"""The virtual time in ns that passes for a thread that has read the clock `_POLLS` times without waiting."""


_STALL_S = 30.0
"""The least real time in s for which one thread may keep all others waiting before an error is raised."""


def never() -> bool:
    """The condition of a thread that waits only for its deadline."""
    return False


class Child:
    """A thread that lives in this virtual time, and the event for which it waits while it does not run."""

    __slots__ = (
        'busy',
        'deadline',
        'gate',
        'looks_outside',
        'outcome',
        'over',
        'polls',
        'ready',
        'stuck',
        'thread',
    )

    def __init__(self, thread: Thread) -> None:
        self.thread = thread
        self.ready: Callable[[], bool] = never
        """Returns True, and takes the awaited item, if the wait is over. Any member's thread calls it; it
        must not block.
        """
        self.deadline: int | None = None
        self.looks_outside = False
        """True if the awaited event may also come from the real world."""
        self.gate = allocate_lock()
        self.gate.acquire()
        self.outcome: bool | None = None
        self.stuck = False
        self.busy = False
        """True while the thread is in the scheduler: signal handlers and finalizers that it runs wait in real
        time.
        """
        self.polls = 0
        self.over = False


class Scheduler:
    """Runs one member at a time. The thread `owner` gets a DeadlockError when no wait could ever end."""

    def __init__(self, owner: Thread, now_ns: int) -> None:
        self.now = now_ns
        """Virtual time, in ns."""
        self.closed = False
        self._lock = allocate_lock()
        self._waiting: dict[Child, None] = {}
        self._running = 1
        self._turns = 0
        self._owner = Child(owner)
        self._children: dict[int, Child] = {get_ident(): self._owner}

    def here(self) -> Child | None:
        """Return the calling thread's member if it may wait in virtual time now; else None."""
        child = self._children.get(get_ident())
        return None if child is None or child.busy or self.closed else child

    def read(self, child: Child) -> int:
        """Return the time. If a thread reads it again and again without waiting, some time passes."""
        child.polls += 1
        if child.polls > _POLLS:
            self.wait(child, never, self.now + _NAP_NS)
        return self.now

    def holds_here(self) -> bool:
        """Return True if the calling thread is a member, even if it may not wait now."""
        return get_ident() in self._children and not self.closed

    # -- waiting

    def wait(
        self, child: Child, ready: Callable[[], bool], deadline: int | None, *, outside: bool = False
    ) -> bool | None:
        """Let other members run until `ready()` returns True (True) or until `deadline` (False).

        Returns None if virtual time has ended, or if only the real world can end the wait: the caller then
        waits in real time. Raises DeadlockError, on the owner's thread, if no wait could ever end.
        """
        child.busy = True
        try:
            with self._lock:
                if self.closed:
                    return None
                child.ready, child.deadline, child.looks_outside = ready, deadline, outside
                self._waiting[child] = None
                self._leave()
            self._sleep(child)
        finally:
            child.busy = False
            child.polls = 0
        if child.stuck:
            child.stuck = False
            raise DeadlockError(describe([each.thread for each in self._waiting], child.thread))
        return child.outcome

    def _sleep(self, child: Child) -> None:
        try:
            self._pass_gate(child)
        except BaseException:  # raised by a signal handler, or because of a deadlock
            with self._lock:
                if child in self._waiting:
                    del self._waiting[child]
                    self._running += 1
                else:
                    child.gate.acquire(blocking=False)
            raise

    def _pass_gate(self, child: Child) -> None:
        turns = -1
        while not child.gate.acquire(timeout=_STALL_S):
            if child is self._owner and turns == self._turns:
                running = [each.thread for each in self._children.values() if each not in self._waiting]
                raise DeadlockError(describe_stall(running, 2 * _STALL_S))
            turns = self._turns

    def _leave(self) -> None:
        """Count one running member less, and choose the next if none runs; the caller holds the lock."""
        self._running -= 1
        if self._running == 0 and self._waiting:
            self._go_on()

    def _go_on(self) -> None:
        """Choose the next member when none runs, and let time pass if none can run."""
        while True:
            for child in self._waiting:
                if child.ready():
                    self._resume(child, outcome=True)
                    return
                if child.deadline is not None and child.deadline <= self.now:
                    self._resume(child, outcome=False)
                    return
            due = min((each.deadline for each in self._waiting if each.deadline is not None), default=None)
            if due is None:
                break
            self.now = due
        outsider = next((each for each in self._waiting if each.looks_outside), None)
        if outsider is not None:
            self._resume(outsider, outcome=None)
            return
        victim = self._owner if self._owner in self._waiting else next(iter(self._waiting))
        victim.stuck = True
        self._resume(victim, outcome=False)

    def _resume(self, child: Child, *, outcome: bool | None) -> None:
        del self._waiting[child]
        self._running += 1
        self._turns += 1
        child.outcome = outcome
        child.ready = never
        child.gate.release()

    # -- members

    def enrol(self, thread: Thread) -> Child:
        """Make a thread a member before it starts. Its turn comes after those of the waiting members."""
        child = Child(thread)
        child.ready = lambda: True
        with self._lock:
            self._waiting[child] = None
        return child

    def strike(self, child: Child) -> None:
        """Remove a member because its thread could not be started."""
        with self._lock:
            self._waiting.pop(child, None)
        child.over = True

    def begin(self, child: Child) -> None:
        """Wait for the first turn of a new member; its own thread calls this."""
        child.busy = True
        child.gate.acquire()
        self._children[get_ident()] = child
        child.busy = False

    def end(self, child: Child) -> None:
        """Note that a member has ended; its own thread calls this."""
        child.busy = child.over = True
        with self._lock:
            if self._children.pop(get_ident(), None) is child and not self.closed:
                self._leave()

    def close(self) -> None:
        """End virtual time. Members that wait go on in real time."""
        self._owner.busy = True
        with self._lock:
            self.closed = True
            for child in tuple(self._waiting):
                self._resume(child, outcome=None)
