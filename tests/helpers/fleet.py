"""The robots of a fleet, which count the goals that they carry out."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager

from example_interfaces.action import Fibonacci

import goalwire

Handler = Callable[[goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]], Awaitable[Fibonacci.Result]]


class Robots:
    """The robots' side: what they have carried out, and when they may end it."""

    def __init__(self) -> None:
        self.executed: Counter[bytes] = Counter()
        self.by_robot: Counter[str] = Counter()
        self.most = 0
        self.canceled = 0
        self.hold = asyncio.Event()
        """Goals of order 0 end when it is set."""
        self._running = 0
        self._began = asyncio.Event()

    @asynccontextmanager
    async def serving(self, *names: str) -> AsyncIterator[Robots]:
        """Serve the action `drive` on each of these robots."""
        async with AsyncExitStack() as stack:
            for name in names:
                node = await stack.enter_async_context(goalwire.Node('driver', namespace=f'/{name}'))
                node.action_server(Fibonacci, 'drive', self._handler(name))
            yield self

    def _handler(self, robot: str) -> Handler:
        async def drive(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
            self.executed[goal.goal_id] += 1
            self.by_robot[robot] += 1
            self._running += 1
            self.most = max(self.most, self._running)
            self._began.set()
            self._began = asyncio.Event()
            try:
                if goal.request.order == 0:
                    await self.hold.wait()
                if goal.request.order == 13 or (goal.request.order == 7 and robot.startswith('bad')):
                    raise goalwire.GoalAborted('an unlucky number')
            except asyncio.CancelledError:
                self.canceled += 1
                raise
            finally:
                self._running -= 1
            return Fibonacci.Result(sequence=[goal.request.order])

        return drive

    async def until(self, count: int) -> None:
        """Wait until so many goals have begun."""
        while self.executed.total() < count:
            await self._began.wait()
