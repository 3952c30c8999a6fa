"""A mission whose runner dies anywhere: each goal is executed once, or a person is asked."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack

from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play
from std_srvs.srv import Trigger

from goalwire.missions import MissionState, Steps, mission
from goalwire.testing.missions import crash_everywhere


@mission()
async def carry(m: Steps, places: int) -> list[int]:
    """Drive to places one after the other, with a call and a sleep between them."""
    drive = m.action(Fibonacci, 'drive')
    tare = m.client(Trigger, 'tare', idempotent=True)
    reached = []
    for place in range(1, places + 1):
        result = await drive.call(order=place, timeout=300)
        reached.append(result.sequence[0])
        await tare.call()
        await m.sleep(5.0)
    return reached


def test_each_goal_is_executed_once_wherever_the_runner_dies(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            runs = await crash_everywhere(
                carry, 2, make_node=lambda: base.graph.node('runner'), folder=base.path.parent
            )
        assert {run.state for run in runs} == {MissionState.SUCCEEDED}
        assert all(run.result == [1, 2] for run in runs)
        assert set(robot.executed.values()) == {1}
        assert len(robot.executed) == 2 * len(runs)
        assert robot.refused == 0  # a server that knows an id never gets it again
        goals = [[each for each in run.sends if 'goal' in each] for run in runs]
        assert all(len(set(sent)) == len(sent) == 2 for sent in goals)
        assert len(runs) > 30

    play(scenario)


@mission(resume='auto')
async def carry_on(m: Steps) -> int:
    drive = m.action(Fibonacci, 'drive')
    await m.client(Trigger, 'tare').call()
    return (await drive.call(order=7)).sequence[0]


def test_a_call_that_may_have_happened_asks_and_is_never_made_twice(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            runs = await crash_everywhere(
                carry_on, make_node=lambda: base.graph.node('runner'), folder=base.path.parent
            )
        asked = [run for run in runs if run.asks]
        assert {run.state for run in asked} == {MissionState.LOST}
        assert [run.boundary for run in asked] == [
            'after write, intent of step 1',
            'before send, step 1, call tare',
            'after send, step 1, call tare',
            'before write, ended of step 1',
        ]
        assert all('may have happened' in run.why for run in asked)
        assert all(run.result == 7 for run in runs if not run.asks)
        assert all(len(set(run.sends)) == len(run.sends) for run in runs)

    play(scenario)


@mission(resume='auto')
async def tour(m: Steps) -> int:
    drive = m.action(Fibonacci, 'drive')
    for place in (1, 2):
        await drive.call(order=place)
    return 2


def test_where_the_server_dies_too_a_goal_that_was_sent_asks(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(robot.served())

            async def restart_server() -> None:
                await stack.aclose()
                await stack.enter_async_context(robot.served())

            runs = await crash_everywhere(
                tour,
                make_node=lambda: base.graph.node('runner'),
                folder=base.path.parent,
                between=restart_server,
            )
        assert set(robot.executed.values()) == {1}
        asked = [run.boundary for run in runs if run.asks]
        # A run asks neither before the intent is written nor after the end is: only while nobody can know.
        kinds = ('after write, intent of', 'before send', 'after send', 'before write, ended of')
        assert all(boundary.startswith(kinds) for boundary in asked)
        assert len(asked) == 2 * len(kinds)
        assert all(run.result == 2 for run in runs if not run.asks)

    play(scenario)


def test_results_that_expired_are_told_by_the_status_array_or_ask(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():

            async def let_results_expire() -> None:
                await asyncio.sleep(30.0 + 1000.0)

            runs = await crash_everywhere(
                tour,
                make_node=lambda: base.graph.node('runner'),
                folder=base.path.parent,
                between=let_results_expire,
            )
        assert set(robot.executed.values()) == {1}
        assert all(run.asks or run.result == 2 for run in runs)
        assert sum(run.asks for run in runs) <= 4

    play(scenario)
