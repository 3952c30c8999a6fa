"""A clock that coroutines can sleep by."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from goalwire.errors import DestroyedError, ROSInterruptException, TimeSourceChangedError
from goalwire.execution.asyncio.waiting import AsyncWaiter
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.clock import Clock, ROSClock
from goalwire.execution.time.steady_clock import STEADY, SteadyClock
from goalwire.rules.time import S_TO_NS, ClockType

if TYPE_CHECKING:
    from typing import Self


class AsyncClock(ROSClock):
    """A clock of any type. A clock of ROS time follows simulated time while simulated time is active."""

    def __new__(
        cls,
        *,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
        source: SteadyClock = STEADY,  # noqa: ARG004
        shutdown_signal: ShutdownSignal | None = None,  # noqa: ARG004
    ) -> Self:
        """Make a clock; raises TypeError if `clock_type` is not a ClockType."""
        if not isinstance(clock_type, ClockType):
            raise TypeError('Clock type must be a ClockType enum')
        return object.__new__(cls)

    def __init__(
        self,
        *,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
        source: SteadyClock = STEADY,
        shutdown_signal: ShutdownSignal | None = None,
    ) -> None:
        """Make a clock. The shutdown that `shutdown_signal` announces ends all of its sleeps."""
        super().__init__(source=source, clock_type=clock_type)
        self._shutdown_signal = shutdown_signal or ShutdownSignal(source)
        self._closed = False
        self._coroutines: dict[AsyncWaiter, None] = {}

    def now_ns(self) -> int:
        return super().now_ns() if self._clock_type is ClockType.ROS_TIME else Clock.now_ns(self)

    def close(self) -> None:
        """Cancel every sleep. Idempotent."""
        self._closed = True
        self.wake_sleepers()

    async def sleep(self, duration_sec: float) -> None:
        """Sleep for a time of this clock. With 0 or less it only gives the loop's other tasks a turn.

        Raises CancelledError if the node is destroyed during the sleep, DestroyedError if it was destroyed
        before the call, TimeSourceChangedError when simulated time is switched on or off,
        ROSInterruptException at shutdown.
        """
        if self._closed:
            raise DestroyedError("cannot sleep: the clock's node was destroyed")
        duration = int(duration_sec * S_TO_NS)
        if duration <= 0:
            await asyncio.sleep(0)
            return
        waiter = AsyncWaiter()
        watch = self._shutdown_signal.watch(waiter.wake)
        self._coroutines[waiter] = None
        try:
            await self._sleep_for(duration, waiter)
        finally:
            del self._coroutines[waiter]
            watch.close()

    async def _sleep_for(self, duration: int, waiter: AsyncWaiter) -> None:
        simulated, switches = self.overridden, self._switches
        now = self.now_ns if simulated else self.source.now
        target = now() + duration
        while True:
            if self._closed:
                raise asyncio.CancelledError('the node was destroyed')
            if self._switches != switches:
                raise TimeSourceChangedError
            missing = target - now()
            if missing <= 0:
                return
            if not self._shutdown_signal.alive:
                raise ROSInterruptException
            await waiter.wait(None if simulated else missing)

    def wake_sleepers(self) -> None:
        super().wake_sleepers()
        for waiter in list(self._coroutines):
            waiter.wake()
