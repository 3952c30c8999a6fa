"""Timers whose callbacks run in an asyncio loop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from helpers.loops import run, turns
from rclpy.clock_type import ClockType
from rclpy.experimental import AsyncNode, AsyncTimer
from rclpy.parameter import Parameter
from rclpy.time import Time
from rclpy.timer import TimerInfo

MakeAsyncNode = Callable[..., AsyncNode]


class Ticks:
    """An async timer callback that counts."""

    def __init__(self) -> None:
        self.count = 0
        self._ticked = asyncio.Event()

    async def __call__(self) -> None:
        self.count += 1
        self._ticked.set()

    async def more(self, number: int = 1) -> None:
        """Wait for further ticks."""
        wanted = self.count + number
        while self.count < wanted:
            self._ticked.clear()
            await self._ticked.wait()


async def other_ticks(node: AsyncNode, period: float = 0.001) -> None:
    """Wait until a timer made now has ticked three times; an older one of that period would have, too."""
    others = Ticks()
    timer = node.create_timer(period, others)
    await others.more(3)
    timer.destroy()


@pytest.mark.parametrize('period', [0.001, 0.0])
def test_a_timer_ticks_until_it_is_destroyed(make_async: MakeAsyncNode, period: float) -> None:
    async def scenario() -> None:
        ticks = Ticks()
        async with make_async() as node:
            timer = node.create_timer(period, ticks)
            assert isinstance(timer, AsyncTimer)
            assert timer.timer_period_ns == period * 1e9
            await ticks.more(3)
            timer.destroy()
            timer.destroy()
            count = ticks.count
            await other_ticks(node, period)
            assert ticks.count == count
            assert list(node.timers) == []

    run(scenario())


def test_a_timer_is_cancelled_reset_and_started_late(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        ticks = Ticks()
        async with make_async() as node:
            timer = node.create_timer(0.001, ticks, autostart=False)
            await other_ticks(node)
            assert timer.is_canceled()
            assert ticks.count == 0
            timer.reset()
            await ticks.more(2)
            timer.cancel()
            count = ticks.count
            await other_ticks(node)
            assert ticks.count == count

    run(scenario())


def test_a_callback_may_destroy_its_own_timer_and_go_on(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        done = asyncio.Event()

        async def once() -> None:
            timer.destroy()
            await turns()  # a cancellation would be raised here
            done.set()

        async with make_async() as node:
            timer = node.create_timer(0.001, once)
            await done.wait()

    run(scenario())


def test_a_callback_that_asks_for_it_gets_a_timer_info(make_async: MakeAsyncNode) -> None:
    async def scenario() -> TimerInfo:
        got: asyncio.Future[TimerInfo] = asyncio.get_running_loop().create_future()

        async def callback(info: TimerInfo) -> None:
            if not got.done():
                got.set_result(info)

        async with make_async() as node:
            node.create_timer(0.001, callback)
            return await got

    info = run(scenario())
    assert info.expected_call_time <= info.actual_call_time


def test_a_timer_follows_simulated_time(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        ticks = Ticks()
        async with make_async(parameter_overrides=[Parameter('use_sim_time', value=True)]) as node:
            clock = node.get_clock()
            assert clock.ros_time_is_active
            clock.set_ros_time_override(Time(clock_type=ClockType.ROS_TIME))
            node.create_timer(1.0, ticks)
            halves = Ticks()
            node.create_timer(0.5, halves)
            clock.set_ros_time_override(Time(nanoseconds=500_000_000, clock_type=ClockType.ROS_TIME))
            await halves.more()
            assert ticks.count == 0
            clock.set_ros_time_override(Time(seconds=1, clock_type=ClockType.ROS_TIME))
            await ticks.more()
            assert ticks.count == 1

    run(scenario())


@pytest.mark.parametrize('period', [-1.0, float('nan')])
def test_a_period_that_is_none_is_refused(make_async: MakeAsyncNode, period: float) -> None:
    node = make_async()
    with pytest.raises((RuntimeError, ValueError)):
        node.create_timer(period, bool)


def test_a_sleep_of_the_nodes_clock_ends_with_the_node(make_async: MakeAsyncNode) -> None:
    async def scenario() -> None:
        async with make_async() as node:
            await node.get_clock().sleep(0.001)
            sleeping = asyncio.create_task(node.get_clock().sleep(60))
            await asyncio.sleep(0)
            node.destroy_node()
            await asyncio.wait([sleeping])
            assert sleeping.cancelled()

    run(scenario())
