"""A thread that rings alarms, for what nobody spins: the deadlines of calls, their backoff, their hooks."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.execution.timer_heap import TimerEntry, TimerHeap
from goalwire.execution.waiting import Waiter

if TYPE_CHECKING:
    from goalwire.execution.shutdown_signal import ShutdownSignal, ShutdownWatch

CLOSING_S = 5.0
"""How long closing waits for the alarm that rings."""


class StopCondition(Protocol):
    """What ends with the shutdown."""

    def end(self) -> None:
        """The shutdown has begun. May come more than once."""


class TimerThread:
    """Rings alarms at their due time (ns of the context's steady clock); the first one starts its thread.

    At the shutdown all that are left ring at once, and later ones as soon as they are set: who
    rings looks at the shutdown signal, and never runs code of users. Setting and dropping cost about one µs
    each and wake nobody, unless the alarm is due before all others.
    """

    def __init__(self, shutdown_signal: ShutdownSignal, name: str) -> None:
        self._shutdown_signal = shutdown_signal
        self._name = name
        self._waiter = Waiter()
        self._timer_heap = TimerHeap(self._on_earlier)
        self._awake_at: int | None = 0
        """When the thread looks at the timer heap anyway; None: never."""
        self._endings: dict[ReferenceType[StopCondition], None] = {}
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._watch: ShutdownWatch | None = None

    def __len__(self) -> int:
        """How many alarms are kept, some of which may have been dropped."""
        return len(self._timer_heap.heap)

    def set(self, alarm: TimerEntry, due: int) -> None:
        """Let `alarm` ring at `due`, instead of any time set before. Any thread."""
        if self._thread is None:
            self._start()
        self._timer_heap.set(alarm, due)
        if not self._shutdown_signal.alive:
            self._ring_all()

    def soon(self, alarm: TimerEntry) -> None:
        """Let `alarm` ring as soon as the thread gets to it."""
        self.set(alarm, 0)

    def tell_end(self, who: StopCondition) -> None:
        """Call `who.end()` at the shutdown, on the thread; at once after it. Held weakly."""
        self._endings[ref(who, self._forget)] = None
        if self._thread is None:
            self._start()
        if not self._shutdown_signal.alive:
            who.end()

    def _forget(self, reference: ReferenceType[StopCondition]) -> None:
        self._endings.pop(reference, None)

    def drop(self, alarm: TimerEntry) -> None:
        """Let `alarm` ring no more; it may be ringing."""
        self._timer_heap.forget(alarm)

    def close(self) -> None:
        """Ring what is left and end the thread, after the shutdown. Idempotent."""
        with self._lock:
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            self._waiter.wake()
            thread.join(CLOSING_S)

    def _start(self) -> None:
        with self._lock:
            if self._thread is None and self._shutdown_signal.alive:
                self._watch = self._shutdown_signal.watch(self._waiter.wake)
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()

    def _on_earlier(self) -> None:
        due, awake_at = self._timer_heap.earliest, self._awake_at
        if due is not None and (awake_at is None or due < awake_at):
            self._waiter.wake()

    def _run(self) -> None:
        timer_heap, shutdown_signal = self._timer_heap, self._shutdown_signal
        try:
            while shutdown_signal.alive:
                self._awake_at = None  # before the look: who sets an earlier alarm after it wakes this thread
                self._awake_at = due = timer_heap.earliest
                shutdown_signal.clock.wait(self._waiter, due)
                self._awake_at = 0
                self._ring(shutdown_signal.clock.now())
        finally:
            if self._watch is not None:
                self._watch.close()
        self._ring_all()

    def _ring_all(self) -> None:
        self._ring(sys.maxsize)
        for reference in list(self._endings):  # no tuple: see ShutdownSignal._tell
            stop = reference()
            if stop is not None:
                stop.end()

    def _ring(self, now: int) -> None:
        while True:
            try:
                self._timer_heap.ring_due(now)
            except Exception as error:  # a mistake of ours: the other alarms must ring all the same
                from goalwire.logging import get_logger  # needed only then
                from goalwire.logging.tracebacks import traceback_text

                get_logger('goalwire.execution').error(
                    f'{self._name}: an alarm failed\n{traceback_text(error)}'
                )
            else:
                return
