"""Goals that go on while their mission does other steps: side by side, cancelled, and after a crash."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack

import pytest
from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play
from std_srvs.srv import Trigger

from goalwire.errors import GoalAborted, GoalCanceled, GoalRefused, MissionFailed
from goalwire.missions import MissionState, Steps, mission
from goalwire.missions.goal_step import CANCEL_S
from goalwire.testing.missions import crash_everywhere


@mission()
async def side_by_side(m: Steps) -> list[int]:
    """Two goals at once, and a call while they run."""
    drive = m.action(Fibonacci, 'drive')
    async with drive.send(order=1) as first, drive.send(order=2) as second:
        await m.client(Trigger, 'tare', idempotent=True).call()
        results = [(await sent.result(timeout=300.0)).sequence[0] for sent in (first, second)]
        assert list((await first.result()).sequence) == [1]  # it may be asked for again
    return results


def test_each_of_two_goals_is_executed_once_wherever_the_runner_dies(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            runs = await crash_everywhere(
                side_by_side, make_node=lambda: base.graph.node('runner'), folder=base.path.parent
            )
        assert {run.state for run in runs} == {MissionState.SUCCEEDED}
        assert all(run.result == [1, 2] for run in runs)
        assert set(robot.executed.values()) == {1}
        assert len(robot.executed) == 2 * len(runs)
        assert robot.refused == 0  # a server that knows an id never gets it again
        assert not robot.cancelled
        assert len(runs) > 25

    play(scenario)


def test_two_goals_take_the_time_of_one(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            begun = asyncio.get_running_loop().time()
            await (await runner.start(side_by_side)).wait()
            assert asyncio.get_running_loop().time() - begun < 1.5 * robot.takes_s

    play(scenario)


@mission()
async def cancel_one(m: Steps) -> str:
    async with m.action(Fibonacci, 'drive').send(order=1) as sent:
        await m.sleep(10.0)
        await sent.cancel()
        try:
            await sent.result()
        except GoalCanceled:
            return 'cancelled'
    return 'reached'


def test_a_goal_is_cancelled_once_wherever_the_runner_dies(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            runs = await crash_everywhere(
                cancel_one, make_node=lambda: base.graph.node('runner'), folder=base.path.parent
            )
        assert {run.result for run in runs} == {'cancelled'}
        assert set(robot.executed.values()) == {1}
        assert len(robot.executed) == len(robot.cancelled) == len(runs)

    play(scenario)


@mission()
async def leave_early(m: Steps, place: int) -> str:
    """Leave the block without the result: by its end, by an error, or by giving up."""
    async with m.action(Fibonacci, 'drive').send(order=place):
        await m.sleep(5.0)
        if place == 2:
            raise RuntimeError('a mistake')
        if place == 3:
            m.give_up('no more')
    return 'left'


@pytest.mark.parametrize('place', [1, 2, 3])
def test_a_goal_whose_result_nobody_took_is_cancelled(base: Base, place: int) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            run = await runner.start(leave_early, place)
            await run.ended.wait()
            assert run.state is (MissionState.SUCCEEDED if place == 1 else MissionState.FAILED)
            assert robot.cancelled == [place]

    play(scenario)


@mission()
async def rest_first(m: Steps) -> None:
    async with m.action(Fibonacci, 'drive').send(order=1) as sent:
        await m.sleep(5.0)
        await sent.result()


def test_a_mission_that_is_cancelled_before_it_takes_the_result_cancels_the_goal(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            run = await runner.start(rest_first, id='m')
            await robot.until(1)
            await runner.pause('m')
            await asyncio.sleep(10.0)  # it waits before the step that takes the result
            states = [run.state]
            await runner.cancel('m')
            await run.ended.wait()
            assert [*states, run.state] == [MissionState.PAUSED, MissionState.CANCELED]
            assert robot.cancelled == [1]

    play(scenario)


def test_a_mission_that_is_cancelled_does_not_wait_for_a_server_that_has_gone(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            await runner.start(rest_first, id='m')
            await robot.until(1)
        async with base.runner(rest_first) as runner:
            [run] = runner.missions()
            await runner.cancel('m')
            async with asyncio.timeout(10 * CANCEL_S):
                await run.ended.wait()
            assert run.state is MissionState.CANCELED

    play(scenario)


@mission()
async def gather_results(m: Steps) -> None:
    drive = m.action(Fibonacci, 'drive')
    async with drive.send(order=1) as first, drive.send(order=2) as second:
        await asyncio.gather(first.result(), second.result())


def test_a_mission_that_takes_results_in_other_tasks_fails_and_cancels_its_goals(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            with pytest.raises(MissionFailed, match='one step after the other'):
                await (await runner.start(gather_results)).wait()
            assert sorted(robot.cancelled) == [1, 2]

    play(scenario)


@pytest.mark.parametrize('undo', [True, False])
def test_cancelling_the_mission_cancels_a_goal_that_was_sent(base: Base, undo: bool) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            run = await runner.start(side_by_side, id='m')
            await robot.until(2)
            await runner.cancel('m', undo=undo)
            await run.ended.wait()
            assert run.state is MissionState.CANCELED
            assert sorted(robot.cancelled) == [1, 2]

    play(scenario)


def test_a_goal_goes_on_if_only_the_runner_ends(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with base.runner() as runner:
                await runner.start(side_by_side, id='m')
                await robot.until(2)
            await asyncio.sleep(robot.takes_s / 2)
            async with base.runner(side_by_side) as runner:
                [run] = runner.missions()
                assert await run.wait() == [1, 2]
        assert robot.places == [1, 2]
        assert not robot.cancelled

    play(scenario)


def test_where_the_server_dies_too_a_goal_that_was_accepted_asks(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(robot.served())

            async def restart_server() -> None:
                await stack.aclose()
                await stack.enter_async_context(robot.served())

            runs = await crash_everywhere(
                side_by_side,
                make_node=lambda: base.graph.node('runner'),
                folder=base.path.parent,
                between=restart_server,
            )
        assert set(robot.executed.values()) == {1}
        assert any(run.asks for run in runs)
        assert all(run.state is MissionState.LOST for run in runs if run.asks)
        assert all(run.result == [1, 2] for run in runs if not run.asks)

    play(scenario)


@pytest.mark.parametrize('answer', ['done', 'again', 'fail'])
def test_a_person_decides_about_a_goal_that_was_lost_after_it_was_accepted(base: Base, answer: str) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            await runner.start(side_by_side, id='m')
            await robot.until(2)
        async with robot.served(), base.runner(side_by_side) as runner:
            [run] = runner.missions()
            for _ in range(2 if answer == 'again' else 1):
                await run.until(MissionState.LOST)
                await runner.answer('m', 'decide', answer)
                await run.until(*set(MissionState) - {MissionState.LOST})
            if answer == 'fail':
                with pytest.raises(MissionFailed, match='may have run'):
                    await run.wait()
            elif answer == 'again':
                assert await run.wait() == [1, 2]
            else:
                with pytest.raises(MissionFailed, match='IndexError'):  # an empty result
                    await run.wait()
        assert robot.places == ([1, 2, 1, 2] if answer == 'again' else [1, 2])

    play(scenario)


@mission()
async def unlucky(m: Steps) -> list[str]:
    drive = m.action(Fibonacci, 'drive')
    ends = []
    for place in (-1, 13):
        try:
            async with drive.send(order=place) as sent:
                await sent.result()
        except (GoalRefused, GoalAborted) as error:
            ends.append(type(error).__name__)
    return ends


def test_refused_and_aborted_goals_raise_as_those_of_call(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served(), base.runner() as runner:
            assert await (await runner.start(unlucky)).wait() == ['GoalRefused', 'GoalAborted']

    play(scenario)


@mission()
async def too_slow(m: Steps) -> str:
    async with m.action(Fibonacci, 'drive').send(order=1) as sent:
        try:
            await sent.result(timeout=10.0)
        except TimeoutError:
            return 'in time'
    return 'late'


def test_a_result_that_does_not_come_in_time_cancels_the_goal(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), base.runner() as runner:
            assert await (await runner.start(too_slow)).wait() == 'in time'
            assert robot.cancelled == [1]  # not only by the end of its server

    play(scenario)


@mission()
async def forgot_the_block(m: Steps) -> None:
    await m.action(Fibonacci, 'drive').send(order=1).result()


def test_a_goal_without_its_block_is_told(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served(), base.runner() as runner:
            with pytest.raises(MissionFailed, match='the goal is sent by'):
                await (await runner.start(forgot_the_block)).wait()

    play(scenario)
