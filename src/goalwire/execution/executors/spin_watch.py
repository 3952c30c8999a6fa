"""Finds a callback that holds up the others, by a sleep or by a loop that waits for another callback.

While a thread spins without end, an alarm looks at it after two seconds, and then less and less often.
Mistakes of this kind show themselves soon, and a robot that runs for days pays nothing. The spinning thread
itself does nothing for it. An executor looks at its timers before each callback. So if a timer is long
overdue, the same callback has been running since then. If only messages wait, a second look follows soon: the
callback is to blame if both looks find it.
"""

from __future__ import annotations

import sys
from threading import get_ident
from typing import TYPE_CHECKING, NamedTuple, Protocol

from goalwire.concurrency.snapshots import copy_of
from goalwire.execution.callback_arguments import CO_COROUTINE
from goalwire.execution.executors.callback_runner import CallbackRunner
from goalwire.execution.time.steady_clock import STEADY, is_machine_time
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.logging import get_logger
from goalwire.places import outermost_program_frame, place_of_frame, source_of_frame

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from threading import Thread
    from types import FrameType

    from goalwire.execution.ready_queue import CallbackSource, ReadyQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal
    from goalwire.execution.time.timer_heap import TimerHeap

FIRST_LOOK_S = 2.0
CONFIRM_S = 1.0
"""The time in s between a look that suspects a callback and the look that confirms it."""
_LONGER = 1.5
"""The factor by which each pause is longer than the pause before."""
_LONGEST_S = 120.0
"""The longest pause in s. After it there are no more looks."""
_OVERDUE_NS = 1_500_000_000
"""A callback is blamed at the first look if a timer is overdue by more than this time in ns."""
_LATE_NS = 500_000_000
"""A second look is made if a timer is overdue by more than this time in ns."""
AWAIT = "in an 'async def' write 'await asyncio.sleep(…)' and await what takes long"
_RETURN = (
    'let it return, and do the rest in a timer, self.create_timer(seconds, self.rest), or in a thread, '
    'threading.Thread(target=self.rest).start(); or spin with a MultiThreadedExecutor and give it '
    'callback_group=MutuallyExclusiveCallbackGroup()'
)
_OWN_GROUP = (
    'callbacks of one callback group never run at the same time, even with a MultiThreadedExecutor: where '
    'the program creates the subscription, timer or service of {}(), write '
    'callback_group=MutuallyExclusiveCallbackGroup(), from rclpy.callback_groups'
)


class Pool(Protocol):
    """The threads of a MultiThreadedExecutor (WorkerPool)."""

    limit: int
    busy: dict[Thread, CallbackSource]


class Suspect(NamedTuple):
    """A callback that may hold up others."""

    frame: FrameType
    mark: object
    """A value that stays equal while the callback does not go on; a second look compares it. None: the
    callback holds up others for certain, and no second look is needed."""
    remedy: str
    said: str = 'the callback {}() has not returned for seconds'


class EndlessSpins:
    """The threads in spins without end of one executor.

    A second thread would wait for ever without running a callback. So it gets the RuntimeError of the newest
    rclpy, unless its program asked to wait.
    """

    def __init__(self) -> None:
        self._threads: list[int] = []
        """Their idents, in the order in which they came."""

    def reset_in_child(self) -> None:
        """Forget the threads that the fork has not copied."""
        me = get_ident()
        self._threads[:] = [thread for thread in self._threads if thread == me]

    def watch(
        self,
        spin: Callable[[], None],
        shutdown_signal: ShutdownSignal,
        find: Callable[[], list[Suspect]],
        *,
        may_wait: bool,
    ) -> None:
        """Spin, and watch the callbacks. Raises RuntimeError if another thread spins, unless `may_wait`."""
        threads, me = self._threads, get_ident()
        try:
            threads.append(me)
            if threads[0] != me and not may_wait:
                raise RuntimeError(
                    'Executor is already spinning: another thread spins it, and runs the callbacks of all '
                    'its nodes; add your node to it by executor.add_node(node) and leave this spin() out, or '
                    'give this thread an executor of its own'
                )
            watch = SpinWatch(shutdown_signal, find)
            try:
                spin()
            finally:
                watch.close()
        finally:
            # Python runs signal handlers after calls, and one that raises finds the thread removed.
            try:  # noqa: SIM105
                threads.remove(me)
            except ValueError:
                pass  # a handler has raised before it was added


class SpinWatch:
    """Watches one spin without end until `close`. Each look calls `find`, which returns the suspects."""

    def __init__(self, shutdown_signal: ShutdownSignal, find: Callable[[], list[Suspect]]) -> None:
        self._shutdown_signal = shutdown_signal
        self._find = find
        self._pause = FIRST_LOOK_S
        self._is_first = True
        self._alarm = TimerEntry(self._look)
        self._marks: list[object] = []
        """The marks of the suspects of the last look, if the next look is to confirm them."""
        for listener in shutdown_signal.spin_listeners.alive():
            listener.on_spin()
        self._set(FIRST_LOOK_S)

    def close(self) -> None:
        """Stop looking."""
        alarms = self._shutdown_signal.alarms
        if alarms is not None:
            alarms.discard(self._alarm)
        self._marks = []

    def _set(self, pause: float) -> None:
        """Set the alarm for the next look. On other clocks than the machine's there are no looks."""
        alarms, clock = self._shutdown_signal.alarms, self._shutdown_signal.clock
        if alarms is not None and is_machine_time(clock):
            alarms.set(self._alarm, clock.now() + int(pause * 1e9))

    def _look(self) -> None:
        if not self._shutdown_signal.alive:
            return
        if self._is_first:
            self._is_first = False
            for look in self._shutdown_signal.early_looks:
                look()
        # A suspect is logged if it has no mark, or a mark that the look before found, too. Then the watch
        # ends. New suspects are confirmed by a look soon after. Otherwise the pause grows.
        suspects = self._find()
        before, self._marks = self._marks, []
        for suspect in suspects:
            if suspect.mark is None or suspect.mark in before:
                _tell(suspect)
                return
        if suspects and not before:
            self._marks = [suspect.mark for suspect in suspects]
            self._set(CONFIRM_S)
            return
        self._pause *= _LONGER
        if self._pause <= _LONGEST_S:
            self._set(self._pause)


def of_this_thread(ready: ReadyQueue, timer_heap: TimerHeap) -> Callable[[], list[Suspect]]:
    """Return a function that finds the callback that holds up the others of the calling thread."""
    thread = get_ident()

    def find() -> list[Suspect]:
        overdue = is_late(timer_heap, _OVERDUE_NS)
        frame = _callback_of(thread) if overdue or _holds_up(copy_of(ready.items)) else None
        return (
            []
            if frame is None
            else [Suspect(frame, None if overdue else _mark(frame), _advise(frame, _RETURN))]
        )

    return find


def of_pool(pool: Pool, ready: ReadyQueue, timer_heap: TimerHeap) -> Callable[[], list[Suspect]]:
    """Return a function that finds callbacks that hold up others of a MultiThreadedExecutor.

    Such callbacks occupy all threads, or the default group of a node. A group that the program chose itself
    is not looked at, since the program wants its callbacks to wait.
    """

    def find() -> list[Suspect]:
        busy = pool.busy.copy()
        are_all_busy = len(busy) >= pool.limit and (_holds_up(copy_of(ready.items)) or is_late(timer_heap))
        more = (
            f'the executor has {pool.limit} threads, and all are in callbacks: let them return, or write '
            'MultiThreadedExecutor(num_threads=…) with a larger number'
        )
        found = []
        for thread, source in busy.items():
            remedy = more if are_all_busy else _OWN_GROUP if _holds_default_group(source) else ''
            frame = _callback_of(thread.ident) if remedy else None
            if frame is not None:
                name = frame.f_code.co_name
                found.append(Suspect(frame, _mark(frame), _advise(frame, remedy.format(name))))
        return found

    return find


def is_late(timer_heap: TimerHeap, by_ns: int = _LATE_NS) -> bool:
    """Tell whether a timer is so late that a callback must have kept it from being called."""
    earliest = timer_heap.earliest
    return earliest is not None and earliest + by_ns < STEADY.now()


def _holds_default_group(source: CallbackSource) -> bool:
    group = source.group
    return group is not None and group.is_default and _holds_up(group.parked)


def _holds_up(waiting: Iterable[CallbackSource]) -> bool:
    """Tell whether one of these sources suffers if it waits for the end of a callback."""
    return any(not source.is_patient for source in waiting)


def _callback_of(thread: int | None) -> FrameType | None:
    """Return the frame of the callback that a thread runs; None if it runs none."""
    frame = None if thread is None else sys._current_frames().get(thread)
    return outermost_program_frame(frame, CallbackRunner.PERFORM)


def _mark(frame: FrameType) -> object:
    """Return the mark of a callback. For a coroutine it also has the position, since all its steps share a
    frame.
    """
    return (frame, frame.f_lasti) if frame.f_code.co_flags & CO_COROUTINE else (frame,)


def _advise(frame: FrameType, otherwise: str) -> str:
    return AWAIT if frame.f_code.co_flags & CO_COROUTINE else otherwise


def _tell(suspect: Suspect) -> None:
    said = suspect.said.format(suspect.frame.f_code.co_qualname)
    line, place = source_of_frame(suspect.frame), place_of_frame(suspect.frame)
    doing = f' (it is at: {line})' if line else ''
    get_logger('goalwire').warning(
        f'{said}{doing}, and other callbacks wait for it: {suspect.remedy} ({place})'
    )
