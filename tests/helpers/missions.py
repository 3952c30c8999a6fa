"""A robot for missions that counts what it does, and lives of runners one after the other."""

from __future__ import annotations

import asyncio
import gc
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

from example_interfaces.action import Fibonacci
from std_srvs.srv import Trigger

import goalwire
from goalwire.missions import Definition, Runner
from goalwire.missions.this_computer import ThisComputer
from goalwire.testing import Graph


class Robot:
    """Serves the action `drive`, 30 s a goal by default, and the service `tare`."""

    def __init__(self) -> None:
        self.takes_s = 30.0
        self.executed: Counter[bytes] = Counter()
        self.places: list[int] = []
        self.cancelled: list[int] = []
        self.tared = 0
        self.refused = 0
        self._began = asyncio.Event()

    async def until(self, count: int) -> None:
        """Wait until so many goals have begun."""
        while len(self.places) < count:
            await self._began.wait()

    @asynccontextmanager
    async def served(self) -> AsyncIterator[Robot]:
        """Serve in the block; the next one is like a restarted server, which knows no goals."""
        async with goalwire.Node('robot') as node:
            server = node.action_server(Fibonacci, 'drive', self._drive, accept=lambda goal: goal.order >= 0)
            node.service(Trigger, 'tare', self._tare)
            yield self
            self.refused = server.statistics().goals.refused

    async def _drive(self, goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        self.executed[goal.goal_id] += 1
        self.places.append(goal.request.order)
        self._began.set()
        self._began = asyncio.Event()
        try:
            await asyncio.sleep(self.takes_s)
        except asyncio.CancelledError:
            self.cancelled.append(goal.request.order)
            raise
        if goal.request.order == 13:
            raise goalwire.GoalAborted('an unlucky place')
        return Fibonacci.Result(sequence=[goal.request.order])

    async def _tare(self, _: Trigger.Request) -> Trigger.Response:
        self.tared += 1
        await asyncio.sleep(3.0)
        return Trigger.Response(success=True)


class Rebooted(ThisComputer):
    """A machine that was restarted since."""

    boot = 'the next one'


class Base:
    """Where runners live, one after the other, on one file."""

    def __init__(self, graph: Graph, folder: Path) -> None:
        self.graph = graph
        self.path = folder / 'missions.db'

    @asynccontextmanager
    async def runner(
        self, *missions: Definition, computer: ThisComputer | None = None
    ) -> AsyncIterator[Runner]:
        """One life."""
        async with (
            self.graph.node('runner') as node,
            Runner(node, self.path, missions=missions, computer=computer) as runner,
        ):
            yield runner

    @contextmanager
    def broken(self) -> Iterator[None]:
        """Break the journal for its runner, and mend it at the end, before the next runner."""
        elsewhere = self.path.with_name('elsewhere.db')
        self.path.rename(elsewhere)
        yield
        elsewhere.rename(self.path)


def play(scenario: Callable[[], Awaitable[Any]]) -> None:
    """Run a scenario in a loop of its own, and make sure that no task ends with an error unheard."""
    unheard: list[dict[str, Any]] = []

    async def watched() -> None:
        asyncio.get_running_loop().set_exception_handler(lambda _, what: unheard.append(what))
        await scenario()

    asyncio.run(watched())
    gc.collect()
    assert not unheard
