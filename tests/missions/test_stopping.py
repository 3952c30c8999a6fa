"""Missions that are paused, cancelled, out of time, or fail: what they undo, and what they leave alone."""

from __future__ import annotations

import asyncio

import pytest
from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play
from std_srvs.srv import Trigger

from goalwire.errors import DeadlineError, GoalAborted, MissionFailed
from goalwire.missions import MissionState, Steps, mission


@mission()
async def there_and_back(m: Steps, *places: int) -> None:
    """Drive to places; if one cannot be reached, go back to those before it, in reverse order."""
    drive = m.action(Fibonacci, 'drive')
    async with m.undo() as undo:
        for place in places:
            await drive.call(order=place)
            undo.push(drive.call, order=place + 100)


def test_a_failure_is_undone_in_reverse_order(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot, base.runner(there_and_back) as runner:
            run = await runner.start(there_and_back, 1, 2, 13)
            with pytest.raises(MissionFailed, match=r'GoalAborted: .*an unlucky place'):
                await run.wait()
            assert robot.places == [1, 2, 13, 102, 101]

    play(scenario)


@pytest.mark.parametrize(('undo', 'places'), [(True, [1, 2, 101]), (False, [1, 2])])
def test_cancelling_cancels_the_goal_and_undoes_if_it_is_to(
    base: Base, undo: bool, places: list[int]
) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot, base.runner(there_and_back) as runner:
            run = await runner.start(there_and_back, 1, 2, 3, id='m')
            await robot.until(2)
            await runner.cancel('m', undo=undo)
            await run.ended.wait()
            assert (run.state, run.why) == (MissionState.CANCELED, 'somebody cancelled it')
            assert (robot.places, robot.cancelled) == (places, [2])

    play(scenario)


def test_the_end_of_a_runner_undoes_nothing_and_an_undo_goes_on_in_the_next(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            for count in (1, 2, 3, 4):  # a life for each goal
                async with base.runner(there_and_back) as runner:
                    await runner.start(there_and_back, 1, 2, 13, id='m')
                    await robot.until(count)
            async with base.runner(there_and_back) as runner:
                (run,) = runner.missions()
                await run.ended.wait()
                assert run.state is MissionState.FAILED
            assert robot.places == [1, 2, 13, 102, 101]
            assert robot.cancelled == []

    play(scenario)


def test_a_cancelled_mission_is_cancelled_by_the_next_runner_if_the_first_one_dies(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(there_and_back) as runner:
                await runner.start(there_and_back, 1, 2, id='m')
                await robot.until(1)
                runner._open_writer().store.command('m', 'cancel', {'undo': True})  # and nobody rings
            async with base.runner(there_and_back) as runner:
                (run,) = runner.missions()
                await run.ended.wait()
                assert run.state is MissionState.CANCELED
            assert (robot.places, robot.cancelled) == ([1], [1])

    play(scenario)


def test_pausing_lets_the_goal_end_and_begins_no_other(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            async with base.runner(there_and_back) as runner:
                run = await runner.start(there_and_back, 1, 2, id='m')
                await robot.until(1)
                await runner.pause('m')
                await run.until(MissionState.PAUSED)
                await asyncio.sleep(100.0)
                assert (robot.places, robot.cancelled, run.state) == ([1], [], MissionState.PAUSED)
            async with base.runner(there_and_back) as runner:  # a restart does not resume it
                (run,) = runner.missions()
                await run.until(MissionState.PAUSED)
                await runner.resume('m')
                await run.wait()
            assert robot.places == [1, 2]

    play(scenario)


def test_a_goal_whose_time_is_over_is_cancelled_and_tried_again_if_it_is_to(base: Base) -> None:
    @mission()
    async def hasty(m: Steps, attempts: int) -> str:
        drive = m.action(Fibonacci, 'drive')
        try:
            await drive.call(order=4, timeout=10.0, attempts=attempts, pause=5.0)
        except DeadlineError as error:
            return str(error)
        return 'reached'

    async def scenario() -> None:
        async with Robot().served() as robot, base.runner(hasty) as runner:
            run = await runner.start(hasty, 3)
            assert await run.wait() == 'step 5, goal drive: its time is over'
            assert (robot.places, robot.cancelled) == ([4, 4, 4], [4, 4, 4])
            assert set(robot.executed.values()) == {1}

    play(scenario)


def test_a_mission_has_a_time_as_a_whole(base: Base) -> None:
    @mission(timeout=45.0)
    async def slow(m: Steps) -> None:
        drive = m.action(Fibonacci, 'drive')
        async with m.undo() as undo:
            undo.push(drive.call, order=0)
            for place in (1, 2, 3):
                await drive.call(order=place)

    async def scenario() -> None:
        async with Robot().served() as robot, base.runner(slow) as runner:
            run = await runner.start(slow)
            with pytest.raises(MissionFailed, match=r'its time of 45\.0 s is over'):
                await run.wait()
            assert (robot.places, robot.cancelled) == ([1, 2, 0], [2])

    play(scenario)


def test_giving_up_and_goals_that_fail_are_the_missions_business(base: Base) -> None:
    @mission()
    async def fussy(m: Steps) -> None:
        drive = m.action(Fibonacci, 'drive')
        with pytest.raises(GoalAborted) as aborted:
            await drive.call(order=13)
        assert aborted.value.name == '/drive'
        assert (await m.client(Trigger, 'tare').call()).success
        m.give_up('no luck')

    async def scenario() -> None:
        async with Robot().served() as robot, base.runner(fussy) as runner:
            run = await runner.start(fussy)
            with pytest.raises(MissionFailed, match=r'failed: no luck$'):
                await run.wait()
            assert (robot.places, robot.tared) == ([13], 1)

    play(scenario)


def test_steps_of_other_tasks_are_refused(base: Base) -> None:
    @mission()
    async def at_once(m: Steps) -> None:
        await asyncio.gather(m.sleep(1.0), m.sleep(2.0))

    async def scenario() -> None:
        async with base.runner(at_once) as runner:
            run = await runner.start(at_once)
            with pytest.raises(MissionFailed, match='one step after the other'):
                await run.wait()

    play(scenario)
