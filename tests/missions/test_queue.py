"""A runner that carries out one mission at a time: the most important one is next, also after a restart."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play

from goalwire.missions import MissionRun, MissionState, Runner, Steps, mission


@mission(resume='auto')
async def drive(m: Steps, place: int) -> int:
    await m.action(Fibonacci, 'drive').call(order=place)
    await m.sleep(5.0)
    return place


@mission(resume='auto')
async def ask_first(m: Steps) -> bool:
    return await m.approve('may I?')


@asynccontextmanager
async def queue(base: Base) -> AsyncIterator[Runner]:
    """One life of a runner."""
    async with (
        base.graph.node('runner') as node,
        Runner(node, base.path, missions=[drive, ask_first], one_at_a_time=True) as runner,
    ):
        yield runner


async def all_of(runs: list[MissionRun]) -> None:
    await asyncio.gather(*(run.wait() for run in runs))


def test_missions_run_one_after_the_other_the_important_ones_first(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), queue(base) as runner:
            runs = [
                await runner.start(drive, place, priority=priority)
                for place, priority in [(1, 0), (2, 0), (3, 5), (4, 5), (5, -1)]
            ]
            await robot.until(1)
            assert [run.state for run in runs] == [MissionState.RUNNING] + 4 * [MissionState.QUEUED]
            await all_of(runs)
        assert robot.places == [1, 3, 4, 2, 5]

    play(scenario)


def test_after_a_restart_the_one_that_had_begun_goes_on_and_the_order_is_kept(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with queue(base) as runner:
                for place, priority in [(1, 0), (2, 0), (3, 5)]:
                    await runner.start(drive, place, id=f'm{place}', priority=priority)
                await robot.until(1)
            async with queue(base) as runner:
                await all_of(runner.missions())
        assert robot.places == [1, 3, 2]

    play(scenario)


def test_a_mission_that_waits_for_a_person_keeps_its_turn(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), queue(base) as runner:
            asks = await runner.start(ask_first, id='asks')
            waits = await runner.start(drive, 1)
            await asks.until(MissionState.APPROVAL)
            await asyncio.sleep(100.0)
            assert waits.state is MissionState.QUEUED
            await runner.answer('asks', 'approve', 'yes')
            assert await waits.wait() == 1

    play(scenario)


def test_a_queued_mission_that_is_cancelled_never_begins(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), queue(base) as runner:
            first = await runner.start(drive, 1)
            second = await runner.start(drive, 2, id='second')
            third = await runner.start(drive, 3)
            await second.until(MissionState.QUEUED)
            await runner.cancel('second')
            await second.ended.wait()
            assert second.state is MissionState.CANCELED
            await all_of([first, third])
        assert robot.places == [1, 3]

    play(scenario)


def test_a_queued_mission_that_is_paused_waits_for_a_person_in_its_turn(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), queue(base) as runner:
            await runner.start(drive, 1)
            second = await runner.start(drive, 2, id='second')
            await second.until(MissionState.QUEUED)
            await runner.pause('second')
            await asyncio.sleep(100.0)
            assert second.state is MissionState.PAUSED
            assert robot.places == [1]
            await runner.resume('second')
            assert await second.wait() == 2

    play(scenario)
