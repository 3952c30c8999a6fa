"""SingleThreadedExecutor: callbacks run on the thread that spins, one at a time."""

from __future__ import annotations

from _thread import allocate_lock
from threading import get_ident
from typing import TYPE_CHECKING, Any

from goalwire.execution.executor import Executor, Timeout
from goalwire.execution.outcomes import ExternalShutdownException
from goalwire.execution.spinning import Stay, settled
from goalwire.execution.waiting import Waiter

if TYPE_CHECKING:
    from goalwire.execution.future import Future
    from goalwire.execution.lifeline import ContextLike


class SingleThreadedExecutor(Executor):
    """One thread at a time drives it. Others that spin it wait for what they want, or for their turn."""

    def __init__(self, *, context: ContextLike | None = None) -> None:
        super().__init__(context=context)
        self._seat = allocate_lock()
        self._driver = 0
        self._driver_parker = self._parker()
        self._successors: list[Waiter] = []

    def spin(self) -> None:
        self._run(None, None, once=False)

    def spin_until_future_complete(self, future: Future[Any], timeout_sec: Timeout = None) -> None:
        self._run(future, self._deadline(timeout_sec), once=False)

    def thread_waits_alone(self) -> bool:
        """Whether the calling thread is the one that drives this."""
        return self._driver == get_ident()

    def _run(self, until: Future[Any] | None, deadline: int | None, *, once: bool) -> None:
        if self._is_done_already(until, once=once):
            return
        if self._driver == get_ident():
            self._run_nested(until, deadline, once=once)
            return
        if not self._sit_down(until, deadline):
            return
        try:
            self._drive(self._driver_parker, until, deadline, once=once)
        finally:
            if not self._lifeline.alive:
                self._close_lanes()
            self._driver = 0
            self._seat.release()
            if self._successors:
                self._call_successor()

    def _sit_down(self, until: Future[Any] | None, deadline: int | None) -> bool:
        """Become the thread that drives this; False where another one did until this one need not."""
        if not self._seat.acquire(blocking=False):
            waiter = Waiter()
            with Stay(None, self._lifeline, waiter, until):
                while not self._wait_for_seat(waiter, deadline):
                    if self._is_shutdown or (until is not None and settled(until)):
                        return False
                    if not self._lifeline.alive:
                        raise ExternalShutdownException
                    if deadline is not None and deadline <= self._clock.now():
                        return False
        self._driver = get_ident()
        return True

    def _wait_for_seat(self, waiter: Waiter, deadline: int | None) -> bool:
        self._successors.append(waiter)
        try:
            if self._seat.acquire(blocking=False):
                return True
            if not self._is_shutdown:
                self._clock.wait(waiter, deadline)
        finally:
            if waiter in self._successors:
                self._successors.remove(waiter)
        return self._seat.acquire(blocking=False)

    def _call_successor(self) -> None:
        """Let all that wait for the seat try: one gets it, the others wait on."""
        for waiter in tuple(self._successors):
            waiter.wake()

    def _send_home(self) -> None:
        self._call_successor()
