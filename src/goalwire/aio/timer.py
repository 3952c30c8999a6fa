"""Timers of the asyncio API: `async for` gets a tick at each period."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.aio.entity import Entity
from goalwire.execution.asyncio.waiting import AsyncQueue
from goalwire.execution.time import timer
from goalwire.rules.time import S_TO_NS

if TYPE_CHECKING:
    from typing import Self

    from goalwire.entities.node import NodeCore
    from goalwire.rules.statistics import TimerStatistics
    from goalwire.rules.time import Time


class Timer(Entity):
    """A timer: `async for time in timer` gives the time of each tick, until the timer is closed.

    It keeps its phase. Ticks that come between two steps of the loop count as one, the latest.
    """

    def __init__(self, node: NodeCore, period: float) -> None:
        """Start the timer. Raises ValueError for a period that is not above 0."""
        if not period > 0:
            raise ValueError(f'a timer needs a period above 0 s, not {period}')
        self.name = f'{node.name.qualified}: {period} s'
        self._node = node
        self._stream: AsyncQueue[Time] = AsyncQueue(1)
        clock = node.clock
        self._core = timer.Timer(
            lambda: self._stream.deliver(clock.now()),
            None,
            int(period * S_TO_NS),
            clock,
            work_queue=node.work_queue,
        )
        node.own(self)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Time:
        """Wait for the next tick."""
        return await anext(self._stream)

    def statistics(self) -> TimerStatistics:
        """Return the number of ticks, and how late they came."""
        return self._core.statistics()

    def close(self) -> None:
        """Stop ticking. Idempotent."""
        self._node.disown(self)
        self._core.destroy()
        self._stream.close()

    destroy = close
