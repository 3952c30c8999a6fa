"""SingleThreadedExecutor: callbacks run on the thread that spins, one at a time."""

from __future__ import annotations

from functools import partial
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException
from goalwire.execution.executors.executor import Executor, Timeout
from goalwire.execution.executors.spin_watch import of_this_thread
from goalwire.execution.executors.stop_conditions import (
    NEVER,
    StopConditionScope,
    stop_condition_of,
)
from goalwire.execution.future import Future
from goalwire.execution.waiters import StopCondition, Waiter, wake_all

if TYPE_CHECKING:
    from goalwire.execution.shutdown_signal import ContextLike


_TURN = 'turn'


class SingleThreadedExecutor(Executor):
    """Runs callbacks on one spinning thread at a time. Other threads that spin it wait for their own future
    or for their turn.

    `_driver` has the ident of the thread whose turn it is, under the key _TURN. It is a dict because
    `setdefault` takes the turn in one step. So a signal's handler that raises cannot leave the ident of a
    thread there that has stopped spinning.
    """

    def __init__(self, *, context: ContextLike | None = None) -> None:
        super().__init__(context=context)
        self._driver: dict[str, int] = {}
        self._driver_waiter = self._new_waiter()
        self._successors: list[Waiter] = []

    def reset_in_child(self) -> None:
        super().reset_in_child()
        if not self.thread_waits_alone():
            self._driver.clear()

    def spin(self) -> None:
        self._spin_without_end(may_wait=False)

    def spin_or_wait(self) -> None:
        self._spin_without_end(may_wait=True)

    def _spin_without_end(self, *, may_wait: bool) -> None:
        if self.thread_waits_alone():
            self._run(None, None, once=False)
            return
        find = of_this_thread(self._ready, self._timer_heap)
        spin = partial(self._run, None, None, once=False)
        self._endless_spins.watch(spin, self._shutdown_signal, find, may_wait=may_wait)

    def spin_until_future_complete(self, future: Future[Any], timeout_sec: Timeout = None) -> None:
        self._run(future, None if timeout_sec is None else self._deadline(timeout_sec), once=False)

    def is_driven(self) -> bool:
        """Tell whether a thread spins this executor."""
        return bool(self._driver)

    def thread_waits_alone(self) -> bool:
        """Tell whether the calling thread has the turn: no callback runs while it blocks."""
        return self._driver.get(_TURN) == get_ident()

    def _run(self, until: Future[Any] | None, deadline: int | None, *, once: bool) -> None:
        stop: StopCondition = NEVER
        if until is not None:  # hot path: `stop_condition_of` would take 0.6 us a spin
            stop = until if isinstance(until, Future) else stop_condition_of(until)  # type: ignore[redundant-expr]
        if stop.completion_state and self._has_nothing_left(once=once):
            return
        driver, me = self._driver, get_ident()
        if driver.get(_TURN) == me:
            self._run_nested(stop, deadline, once=once)
            return
        try:
            if driver.setdefault(_TURN, me) == me or self._await_turn(stop, deadline):
                self._drive(self._driver_waiter, stop, deadline, once=once)
        finally:
            # The turn is freed before any call: Python runs signal handlers after calls, and one that raises
            # would leave the turn taken.
            try:
                has_turn = _TURN in driver and driver[_TURN] == me
            except KeyError:  # without a GIL, the thread with the turn has freed it in between
                has_turn = False
            if has_turn:
                del driver[_TURN]
                if not self._shutdown_signal.alive:
                    self._close_runners()
                if self._successors:
                    self._call_successor()

    def _await_turn(self, stop: StopCondition, deadline: int | None) -> bool:
        """Wait until this thread has the turn; False if `stop`, `deadline` or `shutdown` come first."""
        waiter = Waiter()
        with StopConditionScope(self._shutdown_signal, waiter, stop):
            while not self._wait_for_turn(waiter, deadline):
                if self._is_shutdown or stop.completion_state or self._is_past(deadline):
                    return False
                if not self._shutdown_signal.alive:
                    raise ExternalShutdownException
        return True

    def _wait_for_turn(self, waiter: Waiter, deadline: int | None) -> bool:
        # The waiter is added before the turn is tried. The thread with the turn frees it, then looks for
        # successors. So either the turn is free by now, or that thread wakes this one.
        self._successors.append(waiter)
        try:
            if self._takes_turn():
                return True
            if not self._is_shutdown:
                self._clock.wait(waiter, deadline)
        finally:
            self._successors.remove(waiter)
        return self._takes_turn()

    def _takes_turn(self) -> bool:
        me = get_ident()
        return self._driver.setdefault(_TURN, me) == me

    def _call_successor(self) -> None:
        """Wake all threads that wait for their turn. One of them takes it, and the others wait again."""
        wake_all(self._successors)

    def _wake_workers(self) -> None:
        self._call_successor()
