"""Delivers packets late and in order, on a thread that lives only while packets wait."""

from __future__ import annotations

import time
from collections.abc import Callable
from heapq import heappop, heappush
from threading import Event, Lock, Thread, current_thread
from typing import Any, Protocol

from goalwire.concurrency.threads import begin, join_begun
from goalwire.fault_reports import report_failure
from goalwire.transport.faults.kinds import Path


class Clock(Protocol):
    """The part of `execution.monotonic.SteadyClock` that a delay queue uses; a virtual clock replaces it."""

    def now(self) -> int:
        """Steady time in ns."""

    # `waiter` is of the clock's own type, which has `wait(timeout_ns)` and `wake()`.
    def wait(self, waiter: Any, deadline_ns: int | None) -> bool:
        """Sleep in `waiter` until it is woken (True) or steady time reaches `deadline_ns` (False)."""


class EventWaiter:
    """A waiter in the sense of `goalwire.execution.waiters`: holds one wake-up."""

    def __init__(self) -> None:
        self._woken = Event()

    def wait(self, timeout_ns: int | None = None) -> bool:
        """Sleep until woken (True) or for `timeout_ns` (False)."""
        woken = self._woken.wait(None if timeout_ns is None else max(timeout_ns, 0) / 1e9)
        self._woken.clear()
        return woken

    def wake(self) -> None:
        """End the current or the next `wait`."""
        self._woken.set()


class RealTime:
    """The machine's time."""

    def now(self) -> int:
        """Steady time in ns."""
        return time.monotonic_ns()

    def wait(self, waiter: EventWaiter, deadline_ns: int | None) -> bool:
        """Sleep in `waiter`."""
        return waiter.wait(None if deadline_ns is None else deadline_ns - self.now())


class DelayQueue:
    """Delivers packets late. Those of one path arrive in order, unless one overtakes."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._lock = Lock()
        self._heap: list[tuple[int, int, Path | None, Callable[[], None]]] = []
        self._under_way: dict[Path, tuple[int, int]] = {}
        """How many packets are under way on a path, and when the last of them arrives."""
        self._serial = 0
        self._waiter = EventWaiter()
        self._thread: Thread | None = None

    def carry(self, path: Path, delay_ns: int, deliver: Callable[[], None], *, overtakes: bool) -> None:
        """Deliver a packet: at once on this thread, or after `delay_ns` and earlier packets of its path."""
        with self._lock:
            number, last_due = self._under_way.get(path, (0, 0))
            late = delay_ns > 0 or (number > 0 and not overtakes)
            if late:
                due = self._clock.now() + delay_ns
                if overtakes:
                    self._push(due, None, deliver)
                else:
                    due = max(due, last_due)
                    self._under_way[path] = number + 1, due
                    self._push(due, path, deliver)
        if not late:
            deliver()

    def do_later(self, delay_ns: int, action: Callable[[], None]) -> None:
        """Call `action` after `delay_ns`, on the delay queue's thread."""
        with self._lock:
            self._push(self._clock.now() + delay_ns, None, action)

    def _push(self, due: int, path: Path | None, deliver: Callable[[], None]) -> None:
        self._serial += 1
        heappush(self._heap, (due, self._serial, path, deliver))
        if self._thread is None:
            self._thread = Thread(target=self._run, name='goalwire-faults', daemon=True)
            begin(self._thread)
        elif self._heap[0][1] == self._serial:
            self._waiter.wake()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._heap:
                    self._thread = None
                    return
                due, _, path, deliver = self._heap[0]
                is_due = due <= self._clock.now()
                if is_due:
                    heappop(self._heap)
            if not is_due:
                self._clock.wait(self._waiter, due)
                continue
            try:
                deliver()
            except Exception as error:
                report_failure('delivery under faults', error)
            if path is not None:
                self._on_arrival(path)

    def _on_arrival(self, path: Path) -> None:
        with self._lock:
            number, last_due = self._under_way.get(path, (1, 0))
            if number > 1:
                self._under_way[path] = number - 1, last_due
            else:
                self._under_way.pop(path, None)

    @property
    def under_way(self) -> int:
        """The number of deliveries that wait for their time."""
        with self._lock:
            return len(self._heap)

    def clear(self) -> None:
        """Drop all packets that are under way, and wait for the thread to end."""
        with self._lock:
            self._heap.clear()
            self._under_way.clear()
            thread = self._thread
        if thread is not None and thread is not current_thread():
            self._waiter.wake()
            join_begun(thread)
