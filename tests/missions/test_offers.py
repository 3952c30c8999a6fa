"""Missions that others ask for as goals: a goal with a fixed id that comes twice begins one mission."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any
from uuid import UUID, uuid4

import pytest
from example_interfaces.action import Fibonacci
from helpers.missions import Base, Robot, play

import goalwire
from goalwire.errors import GoalAborted, GoalCanceled, GoalIdTaken, GoalRefused, ServerLostError
from goalwire.missions import MissionState, Runner, Steps, mission, offer
from goalwire.missions.journal_writer import Writer

ORDER = UUID('6ba7b810-9dad-41d1-80b4-00c04fd430c8')


@mission(resume='auto')
async def fetch(m: Steps, place: int) -> int:
    drive = m.action(Fibonacci, 'drive')
    async with m.undo() as undo:
        undo.push(drive.call, order=0)
        await drive.call(order=place)
    return place


@asynccontextmanager
async def offered(base: Base) -> AsyncIterator[Runner]:
    """One life of a runner that carries out one mission at a time, and offers `fetch` as an action."""
    async with (
        base.graph.node('runner') as node,
        Runner(node, base.path, missions=[fetch], one_at_a_time=True) as runner,
    ):
        offer(
            node,
            runner,
            fetch,
            Fibonacci,
            'fetch',
            arguments=lambda goal: [goal.order],
            result=lambda value: Fibonacci.Result(sequence=[value]),
            priority=lambda goal: goal.order,
        )
        yield runner


async def ask(place: int, goal_id: UUID | None = None) -> list[int]:
    """Ask as a program that knows nothing of earlier ones, and return what was fetched."""
    async with goalwire.Node('brain') as node:
        client = node.action(Fibonacci, 'fetch')
        async with client.send(order=place, goal_id=goal_id or uuid4(), keep=True) as run:
            return list((await run.result).sequence)


async def follow(goal_id: UUID) -> list[int]:
    async with goalwire.Node('brain') as node, node.action(Fibonacci, 'fetch').attach(goal_id) as run:
        return list((await run.result).sequence)


def hold_up_the_journal(monkeypatch: pytest.MonkeyPatch) -> tuple[asyncio.Event, asyncio.Event]:
    """Hold up what begins the mission ORDER when it is in the journal. Set the first event then, and wait for
    the second one.
    """
    written, go_on = asyncio.Event(), asyncio.Event()
    run_in_thread = Writer.run

    async def run_slowly(writer: Writer, function: Callable[[], Any]) -> Any:
        value = await run_in_thread(writer, function)
        if not written.is_set():
            is_there = await run_in_thread(writer, lambda: writer.store.mission(ORDER.hex)) is not None
            if is_there and not written.is_set():
                written.set()
                await go_on.wait()
        return value

    monkeypatch.setattr(Writer, 'run', run_slowly)
    return written, go_on


def test_a_goal_is_a_mission_of_the_same_id(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base) as runner:
            assert await ask(3, ORDER) == [3]
            [run] = runner.missions()
            assert (run.row.id, run.row.arguments, run.state) == (ORDER.hex, (3,), MissionState.SUCCEEDED)
        assert robot.places == [3]

    play(scenario)


def test_a_goal_that_comes_again_while_it_runs_is_refused_and_can_be_followed(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base):
            first = asyncio.ensure_future(ask(3, ORDER))
            await robot.until(1)
            with pytest.raises((GoalRefused, GoalIdTaken)):
                await ask(3, ORDER)
            assert await follow(ORDER) == [3]
            assert await first == [3]
        assert robot.places == [3]

    play(scenario)


def test_a_goal_that_comes_again_after_its_runner_died_waits_for_its_mission(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base):
                first = asyncio.ensure_future(ask(3, ORDER))
                await robot.until(1)
            with pytest.raises(ServerLostError):  # and not that the goal was aborted: its mission goes on
                await first
            async with offered(base):
                assert await ask(3, ORDER) == [3]
            async with offered(base):  # the mission has ended: its result is in the journal
                assert await ask(3, ORDER) == [3]
        assert robot.places == [3]
        assert not robot.cancelled

    play(scenario)


def test_a_goal_that_comes_again_after_the_server_forgot_it_begins_nothing(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base):
            assert await ask(3, ORDER) == [3]
            await asyncio.sleep(3600.0)
            assert await ask(3, ORDER) == [3]
        assert robot.places == [3]

    play(scenario)


def test_the_same_id_with_another_goal_is_aborted(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base):
                assert await ask(3, ORDER) == [3]
            async with offered(base):
                with pytest.raises(GoalAborted, match='begun before'):
                    await ask(4, ORDER)
        assert robot.places == [3]

    play(scenario)


def test_goals_queue_by_their_priority(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base):
            first = asyncio.ensure_future(ask(1))
            await robot.until(1)
            others = [asyncio.ensure_future(ask(place)) for place in (2, 3)]
            assert await asyncio.gather(first, *others) == [[1], [2], [3]]
        assert robot.places == [1, 3, 2]

    play(scenario)


def test_cancelling_the_goal_cancels_the_mission_and_undoes_it(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base) as runner, goalwire.Node('brain') as node:
            async with node.action(Fibonacci, 'fetch').send(order=3) as run:
                await robot.until(1)
                await run.cancel()
                with pytest.raises(GoalCanceled):
                    await run.result
            [mission_run] = runner.missions()
            assert mission_run.state is MissionState.CANCELED
        assert robot.places == [3, 0]
        assert robot.cancelled == [3]

    play(scenario)


def test_a_goal_that_is_cancelled_while_its_mission_is_written_cancels_the_mission(
    base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    written, go_on = hold_up_the_journal(monkeypatch)

    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base) as runner, goalwire.Node('brain') as node:
                async with node.action(Fibonacci, 'fetch').send(order=3, goal_id=ORDER) as run:
                    await written.wait()
                    cancelling = asyncio.ensure_future(run.cancel())
                    await asyncio.sleep(1.0)
                    go_on.set()
                    await cancelling
                    with pytest.raises(GoalCanceled):
                        await run.result
                [mission_run] = runner.missions()
                assert mission_run.state is MissionState.CANCELED
            async with offered(base) as runner:  # this one finds no mission to go on with
                assert not runner.missions()

    play(scenario)


def test_a_goal_whose_cancelled_mission_is_still_undone_when_the_program_ends_has_not_ended(
    base: Base,
) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), goalwire.Node('brain') as node:
            async with offered(base) as runner:
                run = await node.action(Fibonacci, 'fetch').send(order=3, goal_id=ORDER).__aenter__()
                await robot.until(1)
                await run.cancel()
                await robot.until(2)
            with pytest.raises(ServerLostError):
                await run.result
            async with offered(base) as runner:
                [mission_run] = runner.missions()
                await mission_run.ended.wait()
                assert mission_run.state is MissionState.CANCELED
        assert robot.places == [3, 0]

    play(scenario)


def test_a_goal_whose_program_ends_while_its_mission_is_written_has_not_ended(
    base: Base, monkeypatch: pytest.MonkeyPatch
) -> None:
    written, go_on = hold_up_the_journal(monkeypatch)

    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base):
                asking = asyncio.ensure_future(ask(3, ORDER))
                await written.wait()
                asyncio.get_running_loop().call_later(1.0, go_on.set)
            with pytest.raises(ServerLostError):
                await asking
            async with offered(base) as runner:
                [run] = runner.missions()
                assert await run.wait() == 3
        assert robot.places == [3]

    play(scenario)


def test_a_goal_whose_journal_breaks_has_not_ended_since_its_mission_goes_on(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base):
                asking = asyncio.ensure_future(ask(3, ORDER))
                await robot.until(1)
                with base.broken(), pytest.raises(ServerLostError):
                    await asking
            async with offered(base):
                assert await ask(3, ORDER) == [3]
        assert robot.places == [3]

    play(scenario)


def test_a_goal_that_comes_when_the_journal_is_broken_has_not_ended_either(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served():
            async with offered(base):
                with base.broken(), pytest.raises(ServerLostError):
                    await ask(3, ORDER)
            async with offered(base):
                assert await ask(3, ORDER) == [3]
        assert robot.places == [3]

    play(scenario)


def test_a_goal_that_is_cancelled_when_the_journal_is_broken_is_not_cancelled(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), goalwire.Node('brain') as node:
            async with offered(base):
                run = await node.action(Fibonacci, 'fetch').send(order=3, goal_id=ORDER).__aenter__()
                await robot.until(1)
                with base.broken():
                    await run.cancel()
                    with pytest.raises(ServerLostError):
                        await run.result
            async with offered(base):
                assert await ask(3, ORDER) == [3]
        assert robot.places == [3]

    play(scenario)


def test_closing_the_server_of_an_offer_ends_no_goal(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with (
            robot.served(),
            base.graph.node('runner') as node,
            Runner(node, base.path, missions=[fetch]) as runner,
        ):
            server = offer(
                node,
                runner,
                fetch,
                Fibonacci,
                'fetch',
                arguments=lambda goal: [goal.order],
                result=lambda value: Fibonacci.Result(sequence=[value]),
            )
            asking = asyncio.ensure_future(ask(3, ORDER))
            await robot.until(1)
            server.close()
            with pytest.raises(ServerLostError):
                await asking
            [run] = runner.missions()
            assert await run.wait() == 3
        assert robot.places == [3]

    play(scenario)


def test_a_mission_that_fails_or_that_a_person_cancels_aborts_its_goal(base: Base) -> None:
    async def scenario() -> None:
        robot = Robot()
        async with robot.served(), offered(base) as runner:
            with pytest.raises(GoalAborted, match='unlucky'):
                await ask(13)
            asking = asyncio.ensure_future(ask(3, ORDER))
            await robot.until(3)
            await runner.cancel(ORDER.hex)
            with pytest.raises(GoalAborted, match='cancelled it'):
                await asking

    play(scenario)
