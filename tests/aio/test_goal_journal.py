"""Action servers with a journal remember ids and results over their restart."""

from __future__ import annotations

import asyncio
import sqlite3
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from uuid import UUID, uuid4

import pytest
from example_interfaces.action import Fibonacci

import goalwire
from goalwire import GoalJournal, GoalState
from goalwire.entities.actions.journal_file import JournalFile
from goalwire.errors import GoalRefused, JournalError, ServerLostError
from goalwire.missions import MissionState, Runner, Steps, mission
from goalwire.rules.goals.states import GoalStatus
from goalwire.testing import Graph, VirtualClock

ID = UUID('6ba7b810-9dad-41d1-80b4-00c04fd430c8')


class Job:
    """A handler that takes 10 s, and counts its goals."""

    def __init__(self) -> None:
        self.executed: Counter[bytes] = Counter()

    async def __call__(self, goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        self.executed[goal.goal_id] += 1
        await asyncio.sleep(10.0)
        if goal.request.order < 0:
            raise goalwire.GoalAborted('no such place')
        return Fibonacci.Result(sequence=[goal.request.order])


class Robot:
    """A server with a journal that is started, stopped, and killed."""

    def __init__(self, graph: Graph, journal: Path | GoalJournal) -> None:
        self.graph = graph
        self.journal = journal
        self.job = Job()

    @asynccontextmanager
    async def served(self) -> AsyncIterator[goalwire.ActionServer[Any, Any, Any]]:
        async with self.graph.node('robot') as node:
            yield node.action_server(Fibonacci, 'job', self.job, journal=self.journal)

    @asynccontextmanager
    async def after_its_death(self) -> AsyncIterator[None]:
        """Serve as a process does whose predecessor has accepted goal ID and was then killed."""
        path = self.journal if isinstance(self.journal, Path) else Path(self.journal.path)
        file = JournalFile(GoalJournal(path))
        assert await file.begin(ID.bytes)
        file.close()
        async with self.served():
            yield


@pytest.fixture
def robot(gw_clock: VirtualClock, gw_graph: Graph, tmp_path: Path) -> Robot:
    return Robot(gw_graph, tmp_path / 'job.goals')


@asynccontextmanager
async def asking(robot: Robot) -> AsyncIterator[goalwire.ActionClient[Any, Any, Any]]:
    async with robot.graph.node('client') as node:
        yield node.action(Fibonacci, 'job')


async def run_goal(robot: Robot, order: int = 7, goal_id: UUID = ID) -> None:
    async with asking(robot) as client, client.send(order=order, goal_id=goal_id) as run:
        assert (await run.result).sequence[0] == order


def test_a_result_outlives_its_server_and_its_keeping_time(robot: Robot) -> None:
    async def scenario() -> None:
        async with robot.served():
            await run_goal(robot)
            await asyncio.sleep(1000.0)  # far longer than the 10 s for which servers keep results
        async with robot.served(), asking(robot) as client:
            found = await client.probe(ID)
            assert (found.state, found.status) == (GoalState.ENDED, GoalStatus.SUCCEEDED)
            assert found.result is not None
            assert found.result.sequence[0] == 7
            async with client.attach(ID) as run:
                assert (await run.result).sequence[0] == 7

    asyncio.run(scenario())


def test_the_reason_of_a_failure_is_kept_too(robot: Robot) -> None:
    async def scenario() -> None:
        async with robot.served():
            with pytest.raises(goalwire.GoalAborted):
                await run_goal(robot, order=-1)
        async with robot.served(), asking(robot) as client, client.attach(ID) as run:
            with pytest.raises(goalwire.GoalAborted, match='no such place'):
                await run.result

    asyncio.run(scenario())


def test_a_known_id_is_never_executed_again(robot: Robot) -> None:
    async def scenario() -> None:
        async with robot.served():
            await run_goal(robot)
            await asyncio.sleep(1000.0)
            with pytest.raises(GoalRefused):
                await run_goal(robot)
        async with robot.served():
            with pytest.raises(GoalRefused):
                await run_goal(robot)
        assert robot.job.executed == {ID.bytes: 1}

    asyncio.run(scenario())


def test_a_goal_whose_server_was_killed_was_begun(robot: Robot) -> None:
    async def scenario() -> None:
        async with robot.after_its_death(), asking(robot) as client:
            found = await client.probe(ID)
            assert found.state is GoalState.SERVER_DIED
            assert 'begun' in found.why
            async with client.attach(ID) as run:
                with pytest.raises(ServerLostError, match='begun, then its server died'):
                    await run.result
        with pytest.raises(GoalRefused):
            async with robot.served():
                await run_goal(robot)
        assert not robot.job.executed

    asyncio.run(scenario())


def test_an_unknown_goal_names_the_journal_that_does_not_have_it(robot: Robot) -> None:
    async def scenario() -> None:
        async with robot.served(), asking(robot) as client:
            journal = await client.find_journal()
            assert journal
            found = await client.probe(uuid4())
            assert (found.state, found.journal) == (GoalState.UNKNOWN, journal)
        async with robot.served(), asking(robot) as client:
            assert await client.find_journal() == journal

    asyncio.run(scenario())


def test_a_server_without_a_journal_names_none(gw_clock: VirtualClock, gw_graph: Graph) -> None:
    async def scenario() -> None:
        async with gw_graph.node('robot') as node, gw_graph.node('client') as asker:
            client = asker.action(Fibonacci, 'job')
            assert await client.find_journal() is None  # nobody answers
            node.action_server(Fibonacci, 'job', Job())
            assert await client.find_journal() == ''

    asyncio.run(scenario())


def test_results_are_kept_by_number_and_statuses_for_ever(robot: Robot, tmp_path: Path) -> None:
    async def scenario() -> None:
        robot.journal = GoalJournal(tmp_path / 'job.goals', results=2)
        async with robot.served(), asking(robot) as client:
            ids = [uuid4() for _ in range(3)]
            for order, goal_id in enumerate(ids):
                await run_goal(robot, order, goal_id)
            first, second, _ = [await client.probe(goal_id) for goal_id in ids]
            assert (first.state, first.status) == (GoalState.RESULT_GONE, GoalStatus.SUCCEEDED)
            assert second.state is GoalState.ENDED

    asyncio.run(scenario())


def test_results_are_kept_by_age(robot: Robot, tmp_path: Path) -> None:
    async def scenario() -> None:
        robot.journal = GoalJournal(tmp_path / 'job.goals', age=100.0)
        async with robot.served(), asking(robot) as client:
            await run_goal(robot)
            await asyncio.sleep(200.0)
            await run_goal(robot, goal_id=uuid4())  # old results go when new ones come
            assert (await client.probe(ID)).state is GoalState.RESULT_GONE

    asyncio.run(scenario())


def test_a_goal_that_its_server_ends_at_its_close_is_aborted(robot: Robot) -> None:
    async def scenario() -> None:
        async with (
            asking(robot) as client,
            robot.served(),
            client.send(order=7, goal_id=ID, keep=True),
        ):
            await asyncio.sleep(5.0)
        async with robot.served(), asking(robot) as again:
            found = await again.probe(ID)
            assert (found.state, found.status) == (GoalState.ENDED, GoalStatus.ABORTED)

    asyncio.run(scenario())


def test_a_goal_for_which_no_place_was_left_is_forgotten(
    gw_clock: VirtualClock, gw_graph: Graph, tmp_path: Path
) -> None:
    async def scenario() -> None:
        async with gw_graph.node('robot') as node, gw_graph.node('client') as asker:
            policy = goalwire.single()
            server = node.action_server(
                Fibonacci, 'job', Job(), policy=policy, journal=tmp_path / 'job.goals'
            )
            client = asker.action(Fibonacci, 'job')

            async def refused(goal_id: UUID) -> bool:
                try:
                    async with client.send(order=1, goal_id=goal_id) as run:
                        await run.result
                except GoalRefused:
                    return True
                return False

            ids = [uuid4(), uuid4()]
            both = await asyncio.gather(*map(refused, ids))
            assert sorted(both) == [False, True]
            loser = ids[both.index(True)]
            assert (await client.probe(loser)).state is GoalState.UNKNOWN
            assert server.statistics().goals.refused == 1

    asyncio.run(scenario())


def test_two_servers_cannot_share_a_journal(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('goalwire.entities.actions.journal_file._WAIT_S', 0.1)

    async def scenario() -> None:
        async with robot.served(), robot.graph.node('other') as other:
            with pytest.raises(JournalError, match='locked') as raised:
                other.action_server(Fibonacci, 'other', Job(), journal=robot.journal)
            assert 'one action server' in raised.value.__notes__[0]

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ('given', 'error', 'text'),
    [
        (7, TypeError, 'journal is the path of a file or a goalwire.GoalJournal, not int'),
        ('no/such/folder/job.goals', JournalError, 'cannot be opened'),
    ],
)
def test_a_wrong_journal_is_refused(
    gw_clock: VirtualClock, gw_graph: Graph, given: object, error: type[Exception], text: str
) -> None:
    async def scenario() -> None:
        async with gw_graph.node('robot') as node:
            with pytest.raises(error, match=text):
                node.action_server(Fibonacci, 'job', Job(), journal=given)  # type: ignore[arg-type]

    asyncio.run(scenario())


@pytest.mark.parametrize('wrong', [{'results': -1}, {'results': 1.5}, {'age': -1.0}, {'age': float('nan')}])
def test_a_wrong_limit_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match='a journal keeps'):
        GoalJournal('job.goals', **wrong)  # type: ignore[arg-type]


def test_a_journal_of_a_later_format_is_left_alone(robot: Robot, tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / 'job.goals') as db:
        db.execute('PRAGMA user_version = 9')
    db.close()

    async def scenario() -> None:
        with pytest.raises(JournalError, match='has the format 9'):
            async with robot.served():
                pass

    asyncio.run(scenario())


def test_a_goal_that_cannot_be_written_is_refused(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object, goal_id: bytes) -> bool:
        raise sqlite3.OperationalError('database or disk is full')

    async def scenario() -> None:
        async with robot.served():
            with monkeypatch.context() as patch:
                patch.setattr(JournalFile, '_begin', fail)
                with pytest.raises(GoalRefused):
                    await run_goal(robot)
            await run_goal(robot)  # nobody has executed it: the same id may come again
        assert robot.job.executed == {ID.bytes: 1}

    asyncio.run(scenario())


# -- missions ----------------------------------------------------------------------------------------------


@mission(resume='auto')
async def once(m: Steps) -> int:
    result = await m.action(Fibonacci, 'job').call(order=7)
    return int(result.sequence[0])


def test_a_mission_whose_server_was_restarted_takes_the_result(robot: Robot, tmp_path: Path) -> None:
    async def scenario() -> None:
        async with robot.served():
            async with robot.graph.node('runner') as node, Runner(node, tmp_path / 'm.db') as runner:
                await runner.start(once, id='m')
                await asyncio.sleep(5.0)
            await asyncio.sleep(20.0)  # it ends while no runner is there
        async with (
            robot.served(),
            robot.graph.node('runner') as node,
            Runner(node, tmp_path / 'm.db', missions=[once]) as runner,
        ):
            assert await runner.missions()[0].wait() == 7
        assert len(robot.job.executed) == 1

    asyncio.run(scenario())


def test_a_mission_sends_what_never_arrived_to_a_server_that_was_restarted(
    robot: Robot, tmp_path: Path
) -> None:
    """Without a journal it would have to ask: the server that came back might have executed it before."""

    class Died(BaseException):
        pass

    def die_before_sending(name: str, _step: str) -> None:
        if name == 'before send':
            raise Died

    async def scenario() -> None:
        path = tmp_path / 'm.db'
        async with (
            robot.served(),
            robot.graph.node('runner') as node,
            Runner(node, path, boundary=die_before_sending) as runner,
        ):
            await runner.start(once, id='m')
            await asyncio.sleep(5.0)
        async with (
            robot.served(),
            robot.graph.node('runner') as node,
            Runner(node, path, missions=[once]) as runner,
        ):
            assert await runner.missions()[0].wait() == 7
        assert len(robot.job.executed) == 1

    asyncio.run(scenario())


def test_a_mission_asks_about_a_goal_whose_server_died(robot: Robot, tmp_path: Path) -> None:
    async def scenario() -> None:
        path = tmp_path / 'm.db'
        async with robot.served() as server:
            async with robot.graph.node('runner') as node, Runner(node, path) as runner:
                await runner.start(once, id='m')
                await asyncio.sleep(5.0)
            (goal_id,) = robot.job.executed
            server.close()
        with sqlite3.connect(tmp_path / 'job.goals') as db:  # as a killed server leaves it
            db.execute('UPDATE goal SET status = 0, result = NULL WHERE id = ?', (goal_id,))
        db.close()
        async with (
            robot.served(),
            robot.graph.node('runner') as node,
            Runner(node, path, missions=[once]) as runner,
        ):
            (run,) = runner.missions()
            await run.until(MissionState.LOST)
            assert 'begun, then its server died' in run.why
            await runner.answer('m', 'decide', 'again')
            assert await run.wait() == 7
        assert sorted(robot.job.executed.values()) == [1, 1]

    asyncio.run(scenario())
