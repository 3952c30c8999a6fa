"""How an executor runs one piece of ready work, and what it keeps for that: the queue, timers, lanes."""

from __future__ import annotations

from _thread import allocate_lock
from collections import deque
from collections.abc import Coroutine
from contextvars import copy_context
from functools import partial
from types import CoroutineType
from typing import TYPE_CHECKING, Any

from goalwire.execution.agenda import Agenda
from goalwire.execution.current import HELD
from goalwire.execution.home import Home
from goalwire.execution.readiness import Readiness
from goalwire.execution.ready import ReadyQueue

if TYPE_CHECKING:
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.lane import Lane, Lanes
    from goalwire.execution.lifeline import Lifeline
    from goalwire.execution.work import Work


class Engine:
    """Finds ready work and runs it on the calling thread. Who calls and who sleeps is up to the executor."""

    _spread_lanes = False

    def __init__(self, lifeline: Lifeline) -> None:
        self._lifeline = lifeline
        self._clock = lifeline.clock
        self._ready = ReadyQueue(self.is_driven)
        self._agenda = Agenda(self._look_again, self._ready.wakers)
        self._readiness = Readiness(self._look_again)
        self._failures: deque[BaseException] = deque()
        self._refused: deque[Work] = deque()
        self._askings = 0
        self._lanes: Lanes | None = None
        self._lanes_lock = allocate_lock()
        self._is_shutdown = False
        self.home = Home()
        """Where the executor's own tasks are posted."""
        self.home.attach(self._ready, self._agenda)

    def is_driven(self) -> bool:
        """Whether somebody spins this, as far as it knows: an executor that a program has written may."""
        return not self._is_shutdown

    def _look_again(self) -> None:
        """Let whoever sleeps until the next timer find out that there is an earlier one, or a descriptor."""
        self._ready.wake_one()

    def _next(self) -> Work | None:
        """The next ready work, or None; timers, file descriptors and waitables are looked at first."""
        ready = self._ready
        if self._agenda.earliest is not None or self._readiness.watched or ready.lookouts:
            self._look_around()
        if ready.items:
            try:
                return ready.items.popleft()
            except IndexError:
                return None  # another thread was quicker
        return None

    def _look_around(self) -> None:
        """Have work posted by the timers, file descriptors and waitables that are ready."""
        earliest = self._agenda.earliest
        if earliest is not None and earliest <= (now := self._clock.now()):
            self._agenda.ring_due(now)
        if self._readiness.watched:
            self._readiness.poll()
        if self._ready.lookouts:
            self._ready.look_out()

    def _perform(self, work: Work) -> bool:
        """Run one callback of `work`; False where its group is busy or its node has left.

        What it holds stays noted until the next callback, mostly one of the same group: to set and reset it
        each time takes 2 us after a sleep. Who calls this puts back what was noted before, in the end.
        """
        if work.home.queue is not self._ready:
            work.home.post(work)
            return False
        group = work.group
        if group is not None:
            if group.foreign:
                if not self._may_begin(work, group):
                    return False
            elif not group.begin(work):
                group.park(work)
                return False
        held = HELD.get()
        if group is None or not group.exclusive:
            if held:
                HELD.set(())
        elif not held or held[0] is not group:
            HELD.set((group,))
        try:
            outcome = work.run()
            if outcome is not None and (type(outcome) is CoroutineType or isinstance(outcome, Coroutine)):
                self._start(outcome, work, group)
                return True
        except BaseException:
            self._end(work, group)
            raise
        self._end(work, group)
        return True

    def _end(self, work: Work, group: CallbackGroup | None) -> None:
        """Note that a callback has ended."""
        if group is not None:
            group.ended(work)
            if group.foreign:
                self._askings += 1
        work.settle()
        if self._refused:
            self._ask_again()

    def _may_begin(self, work: Work, group: CallbackGroup) -> bool:
        """Ask a group whose rule a program has written, and keep the work that it refuses.

        Who asks again counts first, then looks at what is kept; here it is the other way round.
        """
        askings = self._askings
        if group.begin(work):
            return True
        self._refused.append(work)
        if self._askings != askings:
            self._ask_again()
        return False

    def _ask_again(self) -> None:
        """Post what such groups have refused: they are asked after each callback, as in rclpy."""
        for _ in range(len(self._refused)):
            try:
                work = self._refused.popleft()
            except IndexError:
                return
            work.home.post(work)

    def _start(self, coroutine: Coroutine[Any, Any, object], work: Work, group: CallbackGroup | None) -> None:
        """Run a coroutine callback up to its first await, in the order of plain callbacks."""
        lanes = self._lanes or self._open_lanes()
        lanes.start(coroutine, copy_context(), partial(self._end, work, group), group)

    def _raise_failure(self) -> None:
        """Raise what a coroutine callback, or a callback on another thread, has raised."""
        if self._failures:
            raise self._failures.popleft()

    def _fail(self, error: BaseException) -> None:
        self._failures.append(error)

    def _open_lanes(self) -> Lanes:
        from goalwire.execution.lane import Lanes

        with self._lanes_lock:
            if self._lanes is None:
                self._lanes = Lanes(self._make_lane, spread=self._spread_lanes)
        if self._is_shutdown:
            self._lanes.close()
        return self._lanes

    def _make_lane(self) -> Lane:
        from goalwire.execution.lane import Lane

        return Lane(self.home, self._readiness, self._clock, self._fail)

    def _close_lanes(self) -> None:
        if self._lanes is not None:
            self._lanes.close()
        self._readiness.close()
