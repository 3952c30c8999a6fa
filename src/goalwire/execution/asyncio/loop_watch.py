"""Finds what keeps an asyncio loop from running the other callbacks: a time.sleep() in a coroutine.

A look asks the loop for an answer, if it is in the program's code. If none has come by the next look, the
loop has not turned in between. Loops that are not written in Python, such as uvloop's, do not show whether
they are in the program's code, and nothing is told of them.
"""

from __future__ import annotations

import asyncio
import sys
from threading import get_ident
from typing import TYPE_CHECKING
from weakref import WeakSet

from goalwire.execution.spin_watch import Suspect, is_late
from goalwire.places import program_frame

if TYPE_CHECKING:
    from types import FrameType

    from goalwire.execution.asyncio.waiting import LoopWaker
    from goalwire.execution.ready_queue import ReadyQueue
    from goalwire.execution.timer_heap import TimerHeap

_REMEDY = (
    "write 'await asyncio.sleep(…)' and not time.sleep(), and 'await asyncio.to_thread(function)' for what "
    'takes long'
)
_CALLS = asyncio.events.__file__
"""Where asyncio calls what its loop runs: the loop itself, as it waits, has no frame of that file."""
_told: WeakSet[asyncio.AbstractEventLoop] = WeakSet()
"""The loops that were told once: each of their nodes looks."""


class BusyLoop:
    """Looks at the running loop from the thread of an alarm."""

    def __init__(self, waker: LoopWaker, ready: ReadyQueue, timer_heap: TimerHeap) -> None:
        self._loop = asyncio.get_running_loop()
        self._thread = get_ident()
        self._waker = waker
        self._ready = ready
        self._timer_heap = timer_heap
        self._question: object | None = None
        """What the loop has not answered yet."""

    def find(self) -> list[Suspect]:
        """Return what the loop runs, with its unanswered question as the mark."""
        frame = self._running()
        if frame is None or self._loop in _told:
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
        """Whether anything of this library's waits for the loop, but for the question."""
        return bool(self._ready.items) or len(self._waker.calls) > 1 or is_late(self._timer_heap)

    def _running(self) -> FrameType | None:
        """Return the program's function that the loop is in."""
        if not self._loop.is_running():
            return None
        frame = outer = program_frame(sys._current_frames().get(self._thread))
        while outer is not None and outer.f_code.co_filename != _CALLS:
            outer = outer.f_back
        return None if outer is None else frame
