"""A thread that rings alarms, for what nobody spins: the deadlines of calls, their backoff, their hooks."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING, Protocol
from weakref import ReferenceType, ref

from goalwire.execution.agenda import Agenda, Alarm
from goalwire.execution.waiting import Waiter

if TYPE_CHECKING:
    from goalwire.execution.lifeline import Lifeline, Watch

CLOSING_S = 5.0
"""How long closing waits for the alarm that rings."""


class Ending(Protocol):
    """What ends with a lifeline."""

    def end(self) -> None:
        """The lifeline has ended. May come more than once."""


class Alarms:
    """Rings alarms at their due time (ns of the lifeline's steady clock); the first one starts its thread.

    At the end of the lifeline all that are left ring at once, and later ones as soon as they are set: who
    rings looks at the lifeline, and never runs code of users. Setting and dropping cost about a microsecond
    each and wake nobody, unless the alarm is due before all others.
    """

    def __init__(self, lifeline: Lifeline, name: str) -> None:
        self._lifeline = lifeline
        self._name = name
        self._waiter = Waiter()
        self._agenda = Agenda(self._on_earlier)
        self._awake_at: int | None = 0
        """When the thread looks at the agenda anyway; None: never."""
        self._endings: dict[ReferenceType[Ending], None] = {}
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._watch: Watch | None = None

    def __len__(self) -> int:
        """How many alarms are kept, some of which may have been dropped."""
        return len(self._agenda.heap)

    def set(self, alarm: Alarm, due: int) -> None:
        """Let `alarm` ring at `due`, instead of any time set before. Any thread."""
        if self._thread is None:
            self._start()
        self._agenda.set(alarm, due)
        if not self._lifeline.alive:
            self._ring_all()

    def soon(self, alarm: Alarm) -> None:
        """Let `alarm` ring as soon as the thread gets to it."""
        self.set(alarm, 0)

    def tell_end(self, who: Ending) -> None:
        """Call `who.end()` at the end of the lifeline, on the thread; at once after it. Held weakly."""
        self._endings[ref(who, self._forget)] = None
        if self._thread is None:
            self._start()
        if not self._lifeline.alive:
            who.end()

    def _forget(self, reference: ReferenceType[Ending]) -> None:
        self._endings.pop(reference, None)

    def drop(self, alarm: Alarm) -> None:
        """Let `alarm` ring no more; it may be ringing."""
        self._agenda.forget(alarm)

    def close(self) -> None:
        """Ring what is left and end the thread, after the lifeline's end. Idempotent."""
        with self._lock:
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            self._waiter.wake()
            thread.join(CLOSING_S)

    def _start(self) -> None:
        with self._lock:
            if self._thread is None and self._lifeline.alive:
                self._watch = self._lifeline.watch(self._waiter.wake)
                self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
                self._thread.start()

    def _on_earlier(self) -> None:
        due, awake_at = self._agenda.earliest, self._awake_at
        if due is not None and (awake_at is None or due < awake_at):
            self._waiter.wake()

    def _run(self) -> None:
        agenda, lifeline = self._agenda, self._lifeline
        try:
            while lifeline.alive:
                self._awake_at = None  # before the look: who sets an earlier alarm after it wakes this thread
                self._awake_at = due = agenda.earliest
                lifeline.clock.wait(self._waiter, due)
                self._awake_at = 0
                self._ring(lifeline.clock.now())
        finally:
            if self._watch is not None:
                self._watch.close()
        self._ring_all()

    def _ring_all(self) -> None:
        self._ring(sys.maxsize)
        for reference in list(self._endings):  # no tuple: see Lifeline._tell
            ending = reference()
            if ending is not None:
                ending.end()

    def _ring(self, now: int) -> None:
        while True:
            try:
                self._agenda.ring_due(now)
            except Exception as error:  # a mistake of ours: the other alarms must ring all the same
                from goalwire.logging import get_logger  # needed only then
                from goalwire.logging.tracebacks import traceback_text

                get_logger('goalwire.execution').error(
                    f'{self._name}: an alarm failed\n{traceback_text(error)}'
                )
            else:
                return
