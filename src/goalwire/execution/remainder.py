"""What is still to be run, by threads that run callbacks beside each other, before a spin ends."""

from __future__ import annotations

from _thread import allocate_lock
from typing import TYPE_CHECKING

from goalwire.execution.inbox import Inbox

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from threading import Thread

    from goalwire.execution.work import Work


class Remainder:
    """The events that have come by the time a spin's future is settled.

    Workers tell of each callback, after they have noted it as theirs, when it begins and when it has ended;
    `done` is called once the last one has. Callbacks of tasks and timers that run already are not waited
    for: they may be meant to run on.
    """

    def __init__(self, done: Callable[[], None]) -> None:
        self.ended = 0
        """How many callbacks have ended since."""
        self._done = done
        self._lock = allocate_lock()
        self._events: dict[Work, int] = {}  # whose callbacks have not begun
        self._running: set[Thread] = set()
        self._seen: set[Thread] = set()

    def gather(self, ready: Iterable[Work], busy: dict[Thread, Work]) -> None:
        """Count what is `ready`, what waits for the groups of the `busy` workers, and what they are at."""
        with self._lock:
            for work in ready:
                self._count(work)
            for thread, work in busy.items():
                if work.group is not None:
                    for parked in work.group.parked:
                        self._count(parked)
                if isinstance(work, Inbox):
                    self._running.add(thread)
                    self._count(work)

    @property
    def over(self) -> bool:
        """Whether all has been run."""
        return not self._running and not self._events

    def begun(self, thread: Thread, work: Work) -> None:
        """Note that `thread` begins a callback of `work`."""
        with self._lock:
            if thread in self._running:
                return  # it has been gathered
            # A worker's first callback may have left the queue just before that was looked at.
            if work not in self._events and thread not in self._seen and isinstance(work, Inbox):
                self._count(work)
            self._seen.add(thread)
            if work in self._events:
                self._running.add(thread)
                self._take_one(work)

    def has_ended(self, thread: Thread, work: Work, *, performed: bool) -> None:
        """Note that `thread` is through with `work`; not `performed`: its group was busy."""
        with self._lock:
            self.ended += 1
            if thread not in self._running:
                return
            self._running.discard(thread)
            if not performed:
                self._events[work] = self._events.get(work, 0) + 1
            elif not work.backlog:
                self._events.pop(work, None)
            over = self.over
        if over:
            self._done()

    def _count(self, work: Work) -> None:
        if work.backlog:
            self._events[work] = work.backlog

    def _take_one(self, work: Work) -> None:
        left = self._events.pop(work) - 1
        if left:
            self._events[work] = left
