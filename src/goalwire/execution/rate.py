"""Rate: sleeping at a steady rhythm (rclpy.timer.Rate)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import ROSInterruptException

if TYPE_CHECKING:
    from goalwire.execution.shutdown_signal import ContextLike
    from goalwire.execution.timer import Timer
    from goalwire.execution.waiting import Waiter


class Rate:
    """Sleeps until its timer is due. Unlike rclpy's it needs no executor that spins meanwhile.

    One that does has a turn with each tick, whether somebody sleeps or not.
    """

    def __init__(self, timer: Timer, *, context: ContextLike) -> None:
        timer.take_over()
        self._timer = timer
        self._context = context
        self._destroyed = False
        self._ticks = 0
        self._sleepers: list[Waiter] = []

    def destroy(self) -> None:
        """End it, and every sleep in it. Idempotent."""
        self._destroyed = True
        self._timer.destroy()
        for waiter in tuple(self._sleepers):
            waiter.wake()

    def sleep(self) -> None:
        """Block until the next tick; not at all where one has passed since the last sleep.

        Raises RuntimeError when destroyed, ROSInterruptException when the context has ended.
        """
        self._check()
        waiter, before = self._context.shutdown_signal.new_waiter(), self._ticks
        self._sleepers.append(waiter)
        try:
            while self._ticks == before:
                self._wait_for_tick(waiter, before)
                self._check()
        finally:
            self._sleepers.remove(waiter)

    def _wait_for_tick(self, waiter: Waiter, before: int) -> None:
        """Sleep to the next tick and count it, unless another sleeper has done that, or the clock jumped."""
        timer = self._timer
        target = timer.next_call_ns

        def moved() -> bool:
            return self._destroyed or self._ticks != before or timer.next_call_ns != target

        reached = timer.clock.wait_until(target, waiter, self._context.shutdown_signal, moved)
        if reached and self._ticks == before and timer.advance() is not None:
            self._ticks += 1

    def _check(self) -> None:
        if self._destroyed:
            raise RuntimeError('Rate cannot sleep because it has been destroyed')
        if not self._context.ok():
            raise ROSInterruptException
