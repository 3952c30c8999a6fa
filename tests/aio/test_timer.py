"""Timers as async iterators, and the node's clock."""

from __future__ import annotations

import asyncio
import time

import pytest
from helpers.loops import Play
from rosgraph_msgs.msg import Clock

import goalwire
from goalwire.execution.time.steady_clock import SteadyClock


def test_a_timer_ticks_in_phase_and_what_was_missed_is_one_tick(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            start = node.clock.now().nanoseconds
            timer = node.timer(0.01)
            first = await anext(timer)
            assert first.nanoseconds - start >= 10_000_000
            await asyncio.sleep(0.05)  # misses some
            late = await anext(timer)
            assert late.nanoseconds - start >= 20_000_000
            assert (await anext(timer)).nanoseconds > late.nanoseconds
            timer.close()
            timer.close()
            assert [tick async for tick in timer] == []

    play(scenario)


def test_a_period_is_above_zero(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            for period in (0, -1, float('nan')):
                with pytest.raises(ValueError, match='above 0'):
                    node.timer(period)

    play(scenario)


def test_timers_and_sleeps_follow_simulated_time(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node', parameters={'use_sim_time': True}) as node:
            clock = node.publisher(Clock, '/clock')
            timer = node.timer(100.0)
            ticking = asyncio.create_task(anext(timer))
            sleeping = asyncio.create_task(node.clock.sleep(50.0))
            await clock.wait_for_subscribers(timeout=5.0)
            await asyncio.sleep(0)  # both wait from time 0 on
            message = Clock()
            message.clock.sec = 100
            clock.publish(message)
            assert (await ticking).nanoseconds >= 100 * 10**9
            await sleeping

    play(scenario)


def test_a_timer_goes_on_when_the_machines_clock_is_set_back(
    play: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        async with goalwire.Node('ticking') as node:
            timer = node.timer(0.05)
            await anext(timer)
            monkeypatch.setattr(
                SteadyClock, 'system_now', staticmethod(lambda: time.time_ns() - 3600 * 10**9)
            )
            async with asyncio.timeout(10.0):
                for _ in range(3):
                    await anext(timer)
                await node.clock.sleep(0.05)

    play(scenario)
