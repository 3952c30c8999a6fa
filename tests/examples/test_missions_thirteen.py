"""The humanoid's thirteen durable steps: its own servers in virtual time, and a crash at every boundary."""

from __future__ import annotations

import asyncio
import importlib.util
import itertools
import random
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from helpers.chance import fresh_chance
from helpers.robot import ROOT
from humanoid.arm.controllers import Controller
from humanoid.arm.server import ArmActionServer
from humanoid.battery.service import BatteryService
from humanoid.joints.service import JointStateService
from humanoid.navigation.server import NavigationActionServer

import goalwire
from goalwire.missions import Definition, MissionState
from goalwire.testing import Graph, VirtualClock
from goalwire.testing.missions import CrashRun, crash_everywhere

SERVERS = (JointStateService, NavigationActionServer, ArmActionServer, BatteryService)
UNSURE = ('call wave', 'call emergency_stop')
"""The calls that nobody may repeat without a person."""


def mission() -> Definition:
    """Return the example's mission."""
    file = ROOT / 'examples' / 'missions' / 'thirteen.py'
    spec = importlib.util.spec_from_file_location('thirteen', file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found: Definition = module.thirteen
    return found


class World:
    """New servers of the robot for each run, which count how often each goal began."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.executed: list[Counter[bytes]] = []
        """How often each goal began, for each run."""
        for server, name in (
            (NavigationActionServer, '_begin'),
            (ArmActionServer, '_begin'),
            (Controller, '_accept'),
        ):
            monkeypatch.setattr(server, name, self._counting(getattr(server, name)))
        self._graph: Graph | None = None
        self._ends = AsyncExitStack()

    def _counting(self, begin: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
        def counted(server: Any, goal: Any) -> None:
            self.executed[-1][bytes(goal.goal_id.uuid)] += 1
            begin(server, goal)

        return counted

    @asynccontextmanager
    async def served(self) -> AsyncIterator[None]:
        self.executed.append(Counter())
        async with AsyncExitStack() as self._ends:
            await self.restart()
            yield

    async def restart(self) -> None:
        """Let the robot lose its power, and start it again."""
        await self._ends.aclose()
        graph = self._ends.enter_context(Graph())
        for server in SERVERS:
            graph.start(server)
        self._graph = graph

    def node(self) -> AbstractAsyncContextManager[goalwire.Node]:
        """Return the node of a runner."""
        assert self._graph is not None
        return self._graph.node('runner')


def some(chance: random.Random) -> Callable[[str], bool]:
    """Choose every two hundredth boundary, others in each run of the test, so at least one.

    After each crash the servers of the whole robot start again, and the mission is played to its end.
    """
    numbers = itertools.count(chance.randrange(200))
    return lambda _boundary: next(numbers) % 200 == 0


def every(_chance: random.Random) -> Callable[[str], bool]:
    """Choose every boundary."""
    return bool


long = pytest.mark.long, pytest.mark.timeout(3600)


@pytest.mark.slow
@pytest.mark.parametrize('boundaries', [some, pytest.param(every, marks=long)])
@pytest.mark.parametrize('victims', [pytest.param('runner', marks=pytest.mark.long), 'both'])
def test_each_goal_is_executed_once_or_the_mission_asks(
    monkeypatch: pytest.MonkeyPatch,
    gw_clock: VirtualClock,
    tmp_path: Path,
    record_property: Callable[[str, object], None],
    victims: str,
    boundaries: Callable[[random.Random], Callable[[str], bool]],
) -> None:
    world = World(monkeypatch)
    chance = fresh_chance(record_property)

    async def scenario() -> list[CrashRun]:
        return await crash_everywhere(
            mission(),
            make_node=world.node,
            make_world=world.served,
            between=world.restart if victims == 'both' else None,
            chosen=boundaries(chance),
            folder=tmp_path,
        )

    undisturbed, *runs = asyncio.run(scenario())
    assert len(undisturbed.result) == 13
    assert undisturbed.result['raise the left arm'] == 'raised, seen in the joints'
    goals = len(world.executed[0])
    asks = [run for run in runs if run.asks]
    assert runs
    record_property('boundaries', len(runs))
    record_property('goals', goals)
    record_property('asks', '; '.join(f'{run.state}, {run.boundary}' for run in asks))
    assert {count for executed in world.executed for count in executed.values()} == {1}
    for run, executed in zip(runs, world.executed[1:], strict=True):
        assert run.asks or run.state is MissionState.SUCCEEDED, run
        if victims == 'runner' and run.asks:
            assert run.state is MissionState.LOST
            assert any(call in run.why for call in UNSURE), run
        elif victims == 'runner':
            assert run.result.keys() == undisturbed.result.keys()
            assert len(executed) == goals, run
    assert gw_clock.elapsed > 10.0 * (len(runs) + 1)
