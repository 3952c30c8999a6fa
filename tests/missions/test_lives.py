"""Missions over several lives of their runner: they go on, hold, ask, or are stuck."""

from __future__ import annotations

import asyncio

import pytest
from example_interfaces.action import Fibonacci
from helpers.missions import Base, Rebooted, Robot, play
from std_msgs.msg import Float32

import goalwire
from goalwire.errors import DeadlineError, JournalError, MissionError, MissionFailed, MissionIdTaken
from goalwire.missions import Definition, MissionRun, MissionState, Runner, Steps, mission
from goalwire.missions.dry_replay import why_stuck
from goalwire.missions.journal_store import Store
from goalwire.rules.missions.entries import EntryKind


@mission()
async def trip(m: Steps, place: int) -> int:
    drive = m.action(Fibonacci, 'drive')
    await drive.call(order=place)
    return (await drive.call(order=place + 1)).sequence[0]


async def leave_at(base: Base, definition: Definition, robot: Robot, count: int, *arguments: object) -> None:
    """Begin a mission, and end its runner while the goal of that number is under way."""
    async with base.runner(definition) as runner:
        await runner.start(definition, *arguments, id='m')
        await robot.until(count)


def only(runner: Runner) -> MissionRun:
    (run,) = runner.missions()
    return run


def test_a_goal_goes_on_without_its_runner_and_the_next_one_takes_its_result(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, trip, robot, 1, 4)
            await asyncio.sleep(50.0)  # the goal ends, and nobody is there
            async with base.runner(trip) as runner:
                assert await only(runner).wait() == 5
            assert robot.places == [4, 5]
            assert robot.cancelled == []

    play(scenario)


def test_a_known_id_is_not_started_again(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            for _ in range(2):
                async with base.runner(trip) as runner:
                    run = await runner.start(trip, 4, id='order')
                    assert run is await runner.start(trip, 4, id='order')
                    assert await run.wait() == 5
                    with pytest.raises(MissionIdTaken, match='begun before'):
                        await runner.start(trip, 5, id='order')
            assert robot.places == [4, 5]

    play(scenario)


def test_after_a_reboot_nothing_moves_until_a_person_says_so(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, trip, robot, 1, 4)
            await asyncio.sleep(40.0)
            async with base.runner(trip, computer=Rebooted()) as runner:
                run = only(runner)
                await run.until(MissionState.HELD)
                assert run.why == 'the machine was restarted'
                await asyncio.sleep(100.0)
                assert robot.places == [4]
                await runner.resume('m')
                assert await run.wait() == 5
            assert robot.places == [4, 5]

    play(scenario)


def test_a_runner_that_was_away_for_more_than_a_minute_holds(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, trip, robot, 1, 4)
            await asyncio.sleep(61.0)
            async with base.runner(trip) as runner:
                await only(runner).until(MissionState.HELD)
            async with base.runner(trip) as runner:  # it is not forgotten by another restart
                await only(runner).until(MissionState.HELD)
                assert 'was away for 61 s' in only(runner).why
            assert robot.places == [4]

    play(scenario)


@pytest.mark.parametrize(('decision', 'places'), [('again', [4, 4, 5]), ('done', [4, 5]), ('fail', [4])])
def test_a_goal_that_died_with_its_server_is_decided_by_a_person(
    base: Base, decision: str, places: list[int]
) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            await leave_at(base, trip, robot, 1, 4)
        async with robot.served(), base.runner(trip) as runner:
            run = only(runner)
            await run.until(MissionState.LOST)
            assert 'may have run, wholly or in part: the server was restarted since' in run.why
            with pytest.raises(MissionError, match='asks no such question'):
                await runner.answer('m', 'approve', 'yes')
            with pytest.raises(MissionError, match='say done, again, fail'):
                await runner.answer('m', 'decide', 'maybe')
            await runner.answer('m', 'decide', decision)
            await run.ended.wait()
            assert run.state is (MissionState.FAILED if decision == 'fail' else MissionState.SUCCEEDED)
        assert robot.places == places
        assert set(robot.executed.values()) == {1}

    play(scenario)


@pytest.mark.parametrize(('is_done', 'places'), [(True, [4]), (False, [4, 4])])
def test_a_lost_goal_is_decided_by_a_look_at_the_world(base: Base, is_done: bool, places: list[int]) -> None:
    seen: list[int] = []

    async def is_there(_: goalwire.Node, goal: Fibonacci.Goal) -> bool:
        seen.append(goal.order)
        return is_done

    @mission()
    async def look(m: Steps) -> None:
        await m.action(Fibonacci, 'drive', if_lost=is_there).call(order=4)

    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            await leave_at(base, look, robot, 1)
        async with robot.served(), base.runner(look) as runner:
            await only(runner).wait()
        assert (robot.places, seen) == (places, [4])

    play(scenario)


def test_the_world_is_checked_before_a_mission_goes_on(base: Base) -> None:
    answers: list[bool | str] = ['not localised', True]

    async def is_localised(_: goalwire.Node) -> bool | str:
        return answers.pop(0)

    @mission(resume_check=is_localised)
    async def checked(m: Steps) -> None:
        await m.action(Fibonacci, 'drive').call(order=4)

    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, checked, robot, 1)
            async with base.runner(checked) as runner:
                await only(runner).until(MissionState.HELD)
                assert only(runner).why == 'resume_check says no: not localised'
                await runner.resume('m')
                await only(runner).wait()
            assert robot.places == [4]
            assert answers == []

    play(scenario)


def test_changed_code_is_stuck_at_the_step_that_differs_and_goes_on_when_it_fits(base: Base) -> None:
    @mission(name='trip', version=2)
    async def other(m: Steps, place: int) -> int:
        await m.sleep(1.0)
        return (await m.action(Fibonacci, 'drive').call(order=place)).sequence[0]

    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, trip, robot, 2, 4)
            async with base.runner(other) as runner:
                await only(runner).until(MissionState.STUCK)
                assert only(runner).why == (
                    'step 1 was goal drive, and the code asks for sleep 1.0 s; '
                    'the code was changed (version 1 to 2)'
                )
            with Store(base.path) as store:
                row = store.mission('m')
                assert row is not None
                assert await why_stuck(row, trip, store.entries('m')) == ''
                assert 'step 1 was goal' in await why_stuck(row, other, store.entries('m'))
            async with base.runner(trip) as runner:
                assert await only(runner).wait() == 5
            assert robot.places == [4, 5]

    play(scenario)


def test_an_approval_is_asked_once_and_answered_in_a_later_life(base: Base) -> None:
    @mission()
    async def risky(m: Steps) -> str:
        return 'carried' if await m.approve('5 kg: carry it?') else 'left'

    async def scenario() -> None:
        async with base.runner(risky) as runner:
            await (await runner.start(risky, id='m')).until(MissionState.APPROVAL)
        with Store(base.path) as store:
            store.command('m', 'approve', {'step': 0, 'answer': 'yes'})  # nobody is there
        async with base.runner(risky) as runner:
            assert only(runner).state is MissionState.APPROVAL
            assert only(runner).why == '5 kg: carry it?'
            assert await only(runner).wait() == 'carried'
            entries = only(runner).entries()
        assert [entry.kind for entry in entries].count(EntryKind.ASKED) == 1

    play(scenario)


def test_waits_sleeps_and_own_values_answer_from_the_journal(base: Base) -> None:
    calls: list[str] = []

    @mission()
    async def measure(m: Steps) -> list[float]:
        begun = await m.now()
        load = await m.wait(Float32, 'load', lambda kg: kg.data > 0.5, timeout=60)
        await m.run(calls.append, 'once')
        await m.sleep(40.0)
        return [await m.now() - begun, load.data, await m.random()]

    async def scenario() -> None:
        async with base.graph.node('scale') as scale:
            load = scale.publisher(Float32, 'load')
            async with base.runner(measure) as runner:
                run = await runner.start(measure, id='m')
                await load.wait_for_subscribers()
                load.publish(data=0.25)
                await asyncio.sleep(10.0)
                load.publish(data=0.75)
                await asyncio.sleep(10.0)
            await asyncio.sleep(20.0)  # the sleep goes on without a runner
            async with base.runner(measure) as runner:
                took, weight, number = await only(runner).wait()
        assert (calls, weight) == (['once'], 0.75)
        assert 49.9 < took < 51
        assert 0 <= number < 1
        assert run.state is MissionState.RUNNING

    play(scenario)


def test_one_runner_a_file(base: Base) -> None:
    async def scenario() -> None:
        async with base.runner(trip):
            with pytest.raises(JournalError, match='another runner has'):
                async with base.runner(trip):
                    pass

    play(scenario)


def test_a_mission_whose_code_is_not_there_is_kept(base: Base) -> None:
    async def scenario() -> None:
        async with Robot().served() as robot:
            await leave_at(base, trip, robot, 1, 4)
            async with base.runner() as runner:
                assert runner.missions() == []
            with Store(base.path) as store:
                row = store.mission('m')
                assert row is not None
                assert (row.state, row.arguments) == (MissionState.STUCK, (4,))
                assert "does not have the mission 'trip'" in row.why
            async with base.runner(trip) as runner:
                assert await only(runner).wait() == 5

    play(scenario)


def test_values_that_a_journal_cannot_keep_fail_their_step(base: Base) -> None:
    @mission()
    async def greedy(m: Steps) -> str:
        try:
            await m.run(object)
        except goalwire.errors.StepFailed as error:
            return str(error)
        return ''

    async def scenario() -> None:
        async with base.runner(greedy) as runner:
            assert 'not JSON serializable' in await (await runner.start(greedy)).wait()
            with pytest.raises(TypeError):
                await runner.start(greedy, object())
            run = await runner.start(trip, id='no server')
            await run.ended.wait()
            with pytest.raises(MissionFailed, match='missing 1 required positional argument'):
                await run.wait()

    play(scenario)


@mission(resume='auto')
async def in_time(m: Steps) -> str:
    try:
        await m.action(Fibonacci, 'drive').call(order=7, timeout=60.0)
    except DeadlineError as error:
        return str(error)
    return 'reached'


def test_a_goal_that_ended_while_no_runner_was_there_is_reached_though_its_time_is_over(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            await leave_at(base, in_time, robot, 1)
            await asyncio.sleep(200.0)
            async with base.runner(in_time) as runner:
                assert await runner.missions()[0].wait() == 'reached'
        assert robot.executed.total() == 1

    play(scenario)


def test_a_goal_that_still_runs_when_its_time_is_over_is_cancelled(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        robot.takes_s = 1000.0
        async with robot.served():
            await leave_at(base, in_time, robot, 1)
            await asyncio.sleep(200.0)
            async with base.runner(in_time) as runner:
                assert 'its time is over' in await runner.missions()[0].wait()
        assert robot.cancelled == [7]

    play(scenario)


def test_a_goal_that_never_arrived_is_not_sent_after_its_time(base: Base) -> None:
    def die_before_sending(name: str, _step: str) -> None:
        if name == 'before send':
            raise asyncio.CancelledError

    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with (
                base.graph.node('runner') as node,
                Runner(node, base.path, boundary=die_before_sending) as runner,
            ):
                await runner.start(in_time, id='m')
                await asyncio.sleep(5.0)
            await asyncio.sleep(200.0)
            async with base.runner(in_time) as runner:
                assert 'its time is over' in await runner.missions()[0].wait()
        assert not robot.executed

    play(scenario)
