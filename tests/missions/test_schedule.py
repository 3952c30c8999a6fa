"""Schedules start a mission at each slot once: over restarts, gaps, and clocks that are set."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import datetime

import pytest
from helpers.missions import Base, play

from goalwire.missions import Runner, Steps, mission
from goalwire.missions.schedule import Slots
from goalwire.missions.this_computer import ThisComputer

HOUR = 3600.0


@mission(resume='auto')
async def patrol(m: Steps) -> float:
    return await m.now()


class Clock(ThisComputer):
    """A machine whose wall clock can be set."""

    def __init__(self) -> None:
        self.shift = 0.0

    def wall(self) -> float:
        return time.time() + self.shift


@asynccontextmanager
async def life(base: Base, clock: Clock, missed: str = 'skip') -> AsyncIterator[Runner]:
    """A runner with a schedule of one patrol an hour."""
    async with base.runner(patrol, computer=clock) as runner:
        await runner.schedule(patrol, every=HOUR, missed=missed)  # type: ignore[arg-type]
        yield runner


async def until_minute(clock: Clock, minute: float) -> None:
    """Sleep until so many minutes after the next full hour."""
    await asyncio.sleep(HOUR - clock.wall() % HOUR + minute * 60.0)


async def patrols(runner: Runner) -> int:
    """Return how many patrols the file has."""
    assert runner._writer is not None
    return len(await runner._writer.run(runner._writer.store.missions))


def test_each_hour_has_a_patrol(base: Base) -> None:
    async def scenario() -> None:
        clock = Clock()
        async with life(base, clock) as runner:
            await until_minute(clock, 1)
            assert await patrols(runner) == 1
            await asyncio.sleep(3 * HOUR)
            assert await patrols(runner) == 4
        assert {run.row.id.split()[0] for run in runner.missions()} == {'patrol'}

    play(scenario)


@pytest.mark.parametrize(('missed', 'made_up'), [('skip', 0), ('run', 1)])
def test_slots_without_a_runner_are_skipped_or_the_latest_is_made_up_for(
    base: Base, missed: str, made_up: int
) -> None:
    async def scenario() -> None:
        clock = Clock()
        async with life(base, clock, missed) as runner:
            await until_minute(clock, 1)
            assert await patrols(runner) == 1  # the slot before the first life is nobody's
        await asyncio.sleep(5 * HOUR)
        async with life(base, clock, missed) as runner:
            await asyncio.sleep(60.0)
            assert await patrols(runner) == 1 + made_up

    play(scenario)


def test_a_restart_within_a_slot_starts_nothing(base: Base) -> None:
    async def scenario() -> None:
        clock = Clock()
        for minute in (1, -59 + 1):
            async with life(base, clock, 'run') as runner:
                await until_minute(clock, minute)
                assert await patrols(runner) == 1

    play(scenario)


def test_a_clock_that_goes_back_repeats_no_slot(base: Base) -> None:
    async def scenario() -> None:
        clock = Clock()
        async with life(base, clock) as runner:
            await until_minute(clock, 1)
            clock.shift = -10 * 60.0
            await asyncio.sleep(30 * 60.0)  # it is the full hour once more
            assert await patrols(runner) == 1
            await asyncio.sleep(HOUR)
            assert await patrols(runner) == 2

    play(scenario)


def test_a_clock_that_jumps_ahead_by_a_day_starts_one_patrol(base: Base) -> None:
    async def scenario() -> None:
        clock = Clock()
        async with life(base, clock) as runner:
            await until_minute(clock, 1)
            clock.shift = 24 * HOUR
            await asyncio.sleep(5 * 60.0)
            assert await patrols(runner) <= 2
            await asyncio.sleep(HOUR)
            assert await patrols(runner) <= 3

    play(scenario)


def test_a_daily_slot_is_at_its_local_time() -> None:
    slots = Slots(daily='02:30')
    noon = datetime(2026, 6, 1, 12, 0).timestamp()  # noqa: DTZ001 - the local zone is meant
    following = datetime.fromtimestamp(slots.after(noon)).astimezone()
    before = datetime.fromtimestamp(slots.latest(noon)).astimezone()
    assert (following.day, following.hour, following.minute) == (2, 2, 30)
    assert (before.day, before.hour, before.minute) == (1, 2, 30)
    assert slots.after(slots.after(noon)) > slots.after(noon)
    assert slots.latest(slots.after(noon)) == slots.after(noon)


@pytest.mark.parametrize(
    ('wrong', 'text'),
    [
        ({}, 'one of them'),
        ({'daily': '02:00', 'every': 60.0}, 'one of them'),
        ({'daily': '25:00'}, 'a time of the day'),
        ({'daily': '2 am'}, 'a time of the day'),
        ({'every': 0.1}, 'at least 1'),
        ({'every': float('nan')}, 'at least 1'),
        ({'every': 60.0, 'missed': 'twice'}, "missed is 'skip' or 'run'"),
    ],
)
def test_a_wrong_schedule_is_refused(base: Base, wrong: dict[str, object], text: str) -> None:
    async def scenario() -> None:
        async with base.runner(patrol) as runner:
            with pytest.raises(ValueError, match=text):
                await runner.schedule(patrol, **wrong)  # type: ignore[arg-type]

    play(scenario)
