"""Finds what keeps an asyncio loop from running the other callbacks, such as a time.sleep() in a coroutine.

If a look finds the loop running the program's code, the look posts a call to the loop. If the loop has not
run that call by the next look, the loop has not turned in between. Loops that are not written in Python, such
as uvloop's, do not show whether they run the program's code, so they are not watched.
"""

from __future__ import annotations

import asyncio
import sys
from threading import get_ident
from typing import TYPE_CHECKING

from goalwire.execution.executors.spin_watch import Suspect, is_late
from goalwire.places import program_frame
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.execution.asyncio.loop_waker import LoopWaker
    from goalwire.execution.ready_queue import ReadyQueue
    from goalwire.execution.time.timer_heap import TimerHeap

_REMEDY = (
    "write 'await asyncio.sleep(…)' and not time.sleep(), and 'await asyncio.to_thread(function)' for what "
    'takes long'
)
_CALLS = asyncio.events.__file__
"""The file with asyncio's code that calls callbacks. The stack of a waiting loop has no frame of
this file.
"""
_told: WeakMembers[asyncio.AbstractEventLoop] = WeakMembers()
"""The loops about which a warning was logged. Each node of a loop watches the loop, and one warning is
enough.
"""


class BusyLoop:
    """Checks on the alarms' thread whether the loop still turns. To be constructed on the loop's thread."""

    def __init__(self, waker: LoopWaker, ready: ReadyQueue, timer_heap: TimerHeap) -> None:
        self._loop = asyncio.get_running_loop()
        self._thread = get_ident()
        self._waker = waker
        self._ready = ready
        self._timer_heap = timer_heap
        self._question: object | None = None
        """The mark of the posted call that the loop has not run yet; None if there is none."""

    def find(self) -> list[Suspect]:
        """Return the callback that the loop runs, with the mark of the posted call that the loop has not run
        yet.
        """
        frame = self._running()
        if frame is None or self._loop in _told.alive():
            return []
        if self._question is None:
            self._question = object()
            self._waker.call(self._answer)
        elif self._is_awaited():
            _told.add(self._loop)
        else:
            return []
        return [Suspect(frame, self._question, _REMEDY, '{}() has kept the asyncio loop for seconds')]

    def _answer(self) -> None:
        self._question = None

    def _is_awaited(self) -> bool:
        """Tell whether work of this library, besides the posted call, waits for the loop."""
        return bool(self._ready.items) or len(self._waker.calls) > 1 or is_late(self._timer_heap)

    def _running(self) -> FrameType | None:
        """Return the frame of the program's function that the loop runs; None if the loop runs none."""
        if not self._loop.is_running():
            return None
        frame = outer = program_frame(sys._current_frames().get(self._thread))
        while outer is not None and outer.f_code.co_filename != _CALLS:
            outer = outer.f_back
        return None if outer is None else frame
