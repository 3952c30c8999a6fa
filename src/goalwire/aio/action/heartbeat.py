"""Watches that the server of a goal gives signs of life: feedback, or a change of the goal's status."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from goalwire.execution.asyncio.waiting import delay_s
from goalwire.execution.monotonic import timeout_ns
from goalwire.rules.goals.table import GoalStatus

if TYPE_CHECKING:
    from goalwire.execution.monotonic import SteadyClock
    from goalwire.rules.goals.client import ClientGoal


class Heartbeat:
    """Calls `stuck` once, in the loop, when a goal's server was silent for `period` s.

    A sign of life costs one look at the clock; the timer is set anew only when it rings. The silence of a
    goal that is known to wait for its turn (ACCEPTED) means nothing.
    """

    def __init__(
        self, period: float, goal: ClientGoal[Any], clock: SteadyClock, stuck: Callable[[], object]
    ) -> None:
        self._period_ns = timeout_ns(period)
        self._goal = goal
        self._clock = clock
        self._stuck = stuck
        self._heard = clock.now()
        self._loop = asyncio.get_running_loop()
        self._timer = self._loop.call_later(delay_s(self._period_ns), self._look)
        goal.heard = self._hear

    def _hear(self) -> None:
        """Any thread."""
        self._heard = self._clock.now()

    def _look(self) -> None:
        if self._goal.status is GoalStatus.ACCEPTED:
            self._hear()
        left = self._heard + self._period_ns - self._clock.now()
        if left > 0:
            self._timer = self._loop.call_later(delay_s(left), self._look)
        else:
            self.close()
            self._stuck()

    def close(self) -> None:
        """Watch no more. Idempotent."""
        self._goal.heard = None
        self._timer.cancel()
