"""Sleeping by a clock, in a coroutine."""

from __future__ import annotations

import asyncio
import threading

import pytest
from helpers.held_up import HeldUp
from helpers.loops import LOOPS, run, turns

from goalwire.errors import DestroyedError, ROSInterruptException, TimeSourceChangedError
from goalwire.execution.asyncio.clock import AsyncClock
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.clock import ROSClock
from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules.time import ClockType, Time


def _ros(shutdown_signal: ShutdownSignal | None = None) -> AsyncClock:
    return AsyncClock(clock_type=ClockType.ROS_TIME, shutdown_signal=shutdown_signal)


def _simulated(seconds: int = 0) -> AsyncClock:
    clock = _ros()
    clock.set_ros_time_override(_at(seconds))
    clock._set_ros_time_is_active(True)
    return clock


def _at(seconds: float) -> Time:
    return Time(nanoseconds=int(seconds * 1e9), clock_type=ClockType.ROS_TIME)


async def _asleep(clock: AsyncClock, seconds: float) -> asyncio.Task[None]:
    """A task that is in the middle of a sleep."""
    task = asyncio.create_task(clock.sleep(seconds))
    await asyncio.sleep(0)
    return task


@pytest.mark.parametrize('loop', LOOPS)
def test_a_sleep_lasts_as_long_as_asked_for(loop: str) -> None:
    async def scenario() -> None:
        for seconds in (0.0001, 0.0155):
            held_up, start = HeldUp(), STEADY.now()
            await _ros().sleep(seconds)
            assert 0 <= STEADY.now() - start - seconds * 1e9 < (1 + held_up.seconds) * 1e9

    run(scenario(), loop)


@pytest.mark.parametrize('seconds', [0, -1.0])
def test_a_sleep_of_nothing_lets_the_others_have_their_turn(seconds: float) -> None:
    async def scenario() -> list[str]:
        done: list[str] = []
        asyncio.get_running_loop().call_soon(done.append, 'other')
        await _ros().sleep(seconds)
        return done

    assert run(scenario()) == ['other']


def test_a_jump_of_simulated_time_ends_the_sleeps_whose_end_it_passes() -> None:
    async def scenario() -> None:
        clock = _simulated(10)
        short, long = await _asleep(clock, 1.0), await _asleep(clock, 5.0)
        clock.set_ros_time_override(_at(10.9))
        await turns()
        assert not short.done()
        thread = threading.Thread(target=clock.set_ros_time_override, args=(_at(11),))
        thread.start()
        await short
        thread.join()
        assert not long.done()
        clock.set_ros_time_override(_at(15))
        await long

    run(scenario())


@pytest.mark.parametrize('active', [True, False])
def test_switching_simulated_time_ends_a_sleep_with_an_error(active: bool) -> None:
    async def scenario() -> None:
        clock = _ros() if active else _simulated()
        task = await _asleep(clock, 60)
        clock._set_ros_time_is_active(active)
        with pytest.raises(TimeSourceChangedError, match='how long is left is unknown'):
            await task

    run(scenario())


def test_closing_the_clock_cancels_its_sleeps_and_refuses_more() -> None:
    async def scenario() -> None:
        clock = _ros()
        task = await _asleep(clock, 60)
        clock.close()
        clock.close()
        await asyncio.wait([task])
        assert task.cancelled()
        with pytest.raises(DestroyedError):
            await clock.sleep(1)

    run(scenario())


def test_the_end_of_the_context_ends_a_sleep() -> None:
    async def scenario() -> None:
        shutdown_signal = ShutdownSignal()
        task = await _asleep(_ros(shutdown_signal), 60)
        shutdown_signal.end('test')
        with pytest.raises(ROSInterruptException):
            await task

    run(scenario())


def test_a_clock_of_any_type_tells_its_time() -> None:
    for kind in (ClockType.SYSTEM_TIME, ClockType.STEADY_TIME, ClockType.ROS_TIME):
        clock = AsyncClock(clock_type=kind)
        assert isinstance(clock, ROSClock)
        assert clock.clock_type is kind
    assert abs(AsyncClock(clock_type=ClockType.STEADY_TIME).now_ns() - STEADY.now()) < 1e9
    assert abs(AsyncClock().now_ns() - STEADY.system_now()) < 1e9
    with pytest.raises(TypeError, match='Clock type must be a ClockType enum'):
        AsyncClock(clock_type=3)  # type: ignore[arg-type]
