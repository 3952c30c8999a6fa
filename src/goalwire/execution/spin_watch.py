"""Finds a callback that holds up the others: a sleep in it, or a loop that waits for another callback.

While a thread spins without end, an alarm looks after two seconds, and then less and less often: mistakes of
this kind show themselves soon, and a robot that runs for days pays nothing. The spinning thread does nothing
for it. It looks at its timers before each callback: so if one of them is long overdue, the same callback has
been running since then. Where messages wait and no timer does, the callback's frame is compared with that of
the last look.
"""

from __future__ import annotations

import sys
from inspect import CO_COROUTINE
from threading import get_ident
from typing import TYPE_CHECKING

from goalwire.execution.callback_runner import CallbackRunner
from goalwire.execution.monotonic import STEADY, is_machine_time
from goalwire.execution.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.places import outermost_program_frame, place_of_frame

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.execution.ready_queue import ReadyQueue
    from goalwire.execution.timer_heap import TimerHeap
    from goalwire.execution.waiting import ShutdownSignal

FIRST_LOOK_S = 2.0
_LONGER = 1.5
"""How much longer each pause is than the one before."""
_LONGEST_S = 120.0
"""The last pause."""
_OVERDUE_NS = 1_500_000_000
"""How late a timer is before a callback is blamed for it."""


class SpinWatch:
    """Watches one spin without end, on the thread that makes it, until `close`."""

    def __init__(self, shutdown_signal: ShutdownSignal, ready: ReadyQueue, timer_heap: TimerHeap) -> None:
        self._shutdown_signal = shutdown_signal
        self._ready = ready
        self._timer_heap = timer_heap
        self._thread = get_ident()
        self._pause = FIRST_LOOK_S
        self._alarm = TimerEntry(self._look)
        self._seen: FrameType | None = None
        """The callback that ran at the last look, while others waited."""
        self._set()

    def close(self) -> None:
        """Look no more."""
        alarms = self._shutdown_signal.alarms
        if alarms is not None:
            alarms.discard(self._alarm)
        self._seen = None

    def _set(self) -> None:
        """Look after the next pause. Other clocks than the machine's stand still, or leap."""
        alarms, clock = self._shutdown_signal.alarms, self._shutdown_signal.clock
        if alarms is not None and is_machine_time(clock):
            alarms.set(self._alarm, clock.now() + int(self._pause * 1e9))

    def _look(self) -> None:
        if not self._shutdown_signal.alive:
            return
        if self._pause == FIRST_LOOK_S:
            for look in self._shutdown_signal.early_looks:
                look()
        if not self._is_held_up():
            self._pause *= _LONGER
            if self._pause <= _LONGEST_S:
                self._set()

    def _is_held_up(self) -> bool:
        """Tell a callback that holds up others; True if there is one."""
        earliest = self._timer_heap.earliest
        is_overdue = earliest is not None and earliest + _OVERDUE_NS < STEADY.now()
        running = self._running() if is_overdue or self._ready.items else None
        seen, self._seen = self._seen, running
        if running is None or not (is_overdue or running is seen):
            return False
        self._seen = None
        _tell(running)
        return True

    def _running(self) -> FrameType | None:
        """Return the callback that the spinning thread is in."""
        frame = sys._current_frames().get(self._thread)
        return outermost_program_frame(frame, CallbackRunner.PERFORM)


def _tell(callback: FrameType) -> None:
    code = callback.f_code
    remedy = (
        "in an 'async def' write 'await asyncio.sleep(…)' and await what takes long"
        if code.co_flags & CO_COROUTINE
        else 'let it return, and do the rest in a timer or in a thread; or spin with a MultiThreadedExecutor '
        'and give it a callback group of its own'
    )
    get_logger('goalwire').warning(
        f'the callback {code.co_qualname}() has not returned for seconds, and other callbacks wait for it: '
        f'{remedy} ({place_of_frame(callback)})'
    )
