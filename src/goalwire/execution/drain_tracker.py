"""What is still to be run, by threads that run callbacks beside each other, before a spin ends."""

from __future__ import annotations

from _thread import allocate_lock
from typing import TYPE_CHECKING

from goalwire.execution.event_queue import EventQueue

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from threading import Thread

    from goalwire.execution.callback_source import CallbackSource


class DrainTracker:
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
        self._events: dict[CallbackSource, int] = {}  # whose callbacks have not begun
        self._running: set[Thread] = set()
        self._seen: set[Thread] = set()

    def gather(self, ready: Iterable[CallbackSource], busy: dict[Thread, CallbackSource]) -> None:
        """Count what is `ready`, what waits for the groups of the `busy` workers, and what they are at."""
        with self._lock:
            for source in ready:
                self._count(source)
            for thread, source in busy.items():
                if source.group is not None:
                    for parked in source.group.parked:
                        self._count(parked)
                if isinstance(source, EventQueue):
                    self._running.add(thread)
                    self._count(source)

    @property
    def over(self) -> bool:
        """Whether all has been run."""
        return not self._running and not self._events

    def begun(self, thread: Thread, source: CallbackSource) -> None:
        """Note that `thread` begins a callback of `work`."""
        with self._lock:
            if thread in self._running:
                return  # it has been gathered
            # A worker's first callback may have left the queue just before that was looked at.
            if source not in self._events and thread not in self._seen and isinstance(source, EventQueue):
                self._count(source)
            self._seen.add(thread)
            if source in self._events:
                self._running.add(thread)
                self._take_one(source)

    def has_ended(self, thread: Thread, source: CallbackSource, *, performed: bool) -> None:
        """Note that `thread` is through with `work`; not `performed`: its group was busy."""
        with self._lock:
            self.ended += 1
            if thread not in self._running:
                return
            self._running.discard(thread)
            if not performed:
                self._events[source] = self._events.get(source, 0) + 1
            elif not source.backlog:
                self._events.pop(source, None)
            over = self.over
        if over:
            self._done()

    def _count(self, source: CallbackSource) -> None:
        if source.backlog:
            self._events[source] = source.backlog

    def _take_one(self, source: CallbackSource) -> None:
        left = self._events.pop(source) - 1
        if left:
            self._events[source] = left
