"""Rate: sleeping at a steady rhythm (rclpy.timer.Rate)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import ROSInterruptException
from goalwire.execution.waiting import Waiter

if TYPE_CHECKING:
    from goalwire.execution.lifeline import ContextLike
    from goalwire.execution.timer import Timer


class Rate:
    """Sleeps until its timer is due. Unlike rclpy's it needs no executor that spins meanwhile."""

    def __init__(self, timer: Timer, *, context: ContextLike) -> None:
        timer.take_over()
        self._timer = timer
        self._context = context
        self._destroyed = False
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
        waiter = Waiter()
        self._sleepers.append(waiter)
        try:
            while not self._tick(waiter):
                self._check()
        finally:
            self._sleepers.remove(waiter)

    def _tick(self, waiter: Waiter) -> bool:
        """Wait for the next tick; False where the clock has jumped and it is another one now."""
        timer = self._timer
        target = timer.next_call_ns

        def moved() -> bool:
            return self._destroyed or timer.next_call_ns != target

        reached = timer.clock.wait_until(target, waiter, self._context.lifeline, moved)
        self._check()
        if timer.next_call_ns != target:
            return timer.next_call_ns > target  # another sleeper has counted this tick
        if reached:
            timer.advance()
        return reached

    def _check(self) -> None:
        if self._destroyed:
            raise RuntimeError('Rate cannot sleep because it has been destroyed')
        if not self._context.ok():
            raise ROSInterruptException
