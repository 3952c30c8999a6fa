"""A bag beside live servers: sent to them, compared with them, and in their place."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from geometry_msgs.msg import PoseStamped
from helpers.command_line import Begin, CommandLine
from helpers.loops import Play
from helpers.patience import PATIENCE

import goalwire
from goalwire.apps.bag.answering import Answers
from goalwire.apps.bag.live_comparison import Replay, ReplayOptions
from goalwire.apps.bag.message_comparison import Tolerance, compare
from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.bag.player import Player
from goalwire.apps.bag.recorded_requests import RecordedCall, RecordedGoal, read_recorded
from goalwire.apps.bag.recorder import Recorder
from goalwire.apps.bag.selection import Names, Selection
from goalwire.errors import GoalCanceled, GoalRefused, ServerFailedError
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer

CALLS = Selection(Names(), Names(all=True), Names(all=True))
FAST = ReplayOptions(rate=1000.0)
ENDLESS = 1_000_000


class Servers:
    """A service that adds, and an action that counts; one number can be wrong, and one feedback missing."""

    def __init__(self, node: goalwire.Node, *, wrong: int = 0, skipped: int = 0) -> None:
        self.requests: list[Any] = []
        self.canceled_at: list[int] = []
        self._wrong = wrong
        self._skipped = skipped
        self.add = node.service(AddTwoInts, 'add', self._add)
        self.count = node.action_server(Fibonacci, 'count', self._count, accept=lambda goal: goal.order != 13)

    async def _add(self, request: AddTwoInts.Request) -> AddTwoInts.Response:
        self.requests.append(('add', request.a, request.b))
        return AddTwoInts.Response(sum=request.a + request.b + self._wrong)

    async def _count(self, goal: Any) -> Fibonacci.Result:
        order = goal.request.order
        self.requests.append(('count', order))
        if order == 7:
            raise goalwire.GoalAborted('seven', result=Fibonacci.Result(sequence=[7]))
        reached = 0
        try:
            while reached < order - self._skipped:
                reached += 1
                goal.feedback(sequence=[reached])
                await asyncio.sleep(0.01 if order == ENDLESS else 0.0)
        except asyncio.CancelledError:
            self.canceled_at.append(reached)
            raise
        return Fibonacci.Result(sequence=[order, order + self._wrong])


async def ask(node: goalwire.Node) -> None:
    """Make the recorded calls and goals; goals succeed, are aborted, refused, and cancelled in the middle."""
    add, count = node.client(AddTwoInts, 'add'), node.action(Fibonacci, 'count')
    for b in (1, 2, 1):
        await add.call(a=40, b=b, timeout=PATIENCE)
    await count.call(order=3, timeout=PATIENCE)
    for order, failure in ((7, goalwire.GoalAborted), (13, GoalRefused)):
        with pytest.raises(failure):
            await count.call(order=order, timeout=PATIENCE)
    async with count.send(order=ENDLESS, timeout=PATIENCE) as run:
        async for feedback in run.feedback:
            if feedback.sequence[0] == 5:
                await run.cancel()
        with pytest.raises(GoalCanceled):
            await run.result


async def until_asked(*parts: Any) -> None:
    async with asyncio.timeout(PATIENCE):
        while not all(part.recorded for part in parts):  # noqa: ASYNC110 - nothing tells of it
            await asyncio.sleep(0.005)


async def record(path: Path, wrong: int = 0) -> None:
    async with goalwire.Node('server') as server, goalwire.Node('caller') as caller:
        servers = Servers(server, wrong=wrong)
        async with goalwire.Node('recorder') as node, Recorder(node, Writer(path), CALLS) as recorder:
            await until_asked(servers.add._core, *servers.count._core._endpoints.servers)
            await ask(caller)
            async with asyncio.timeout(PATIENCE):  # the last answer, and its feedback
                while recorder.count < 3 * 2 + 4 * 2 + 3 * 2 + 2 + 3 + 5:  # noqa: ASYNC110
                    await asyncio.sleep(0.005)


@pytest.fixture
def bag(play: Play, tmp_path: Path) -> Path:
    play(lambda: record(tmp_path / 'bag'))
    return tmp_path / 'bag'


def replayed(play: Play, bag: Path, options: ReplayOptions, **changes: int) -> tuple[list[str], Servers]:
    async def scenario() -> tuple[list[str], Servers]:
        async with goalwire.Node('server') as server, goalwire.Node('player') as node:
            servers = Servers(server, **changes)
            with Reader(bag) as read:
                differences = await Replay(node, read, options).run()
            return [str(difference) for difference in differences], servers

    return play(scenario)


@pytest.mark.also_on_dds
def test_a_bag_tells_calls_and_goals(bag: Path) -> None:
    with Reader(bag) as read:
        recorded = read_recorded(read)
    calls = [each for each in recorded if isinstance(each, RecordedCall)]
    goals = [each for each in recorded if isinstance(each, RecordedGoal)]
    assert [(call.request.b, call.response.sum) for call in calls] == [(1, 41), (2, 42), (1, 41)]
    assert [goal.goal.order for goal in goals] == [3, 7, 13, ENDLESS]
    assert [goal.is_accepted for goal in goals] == [True, True, False, True]
    assert [goal.status for goal in goals] == [4, 6, 0, 5]
    assert [list(goal.result.sequence) if goal.result else None for goal in goals] == [[3, 3], [7], None, []]
    assert len(goals[0].feedback) == 3
    assert goals[3].feedback_before(goals[3].cancels[0]) >= 5


@pytest.mark.also_on_dds
def test_servers_that_answer_as_recorded_differ_in_nothing(play: Play, bag: Path) -> None:
    differences, servers = replayed(play, bag, FAST)
    assert [each for each in differences if 'feedback' not in each] == []
    assert [each for each in differences if f'order={ENDLESS}' not in each] == []
    assert servers.requests == [
        *(('add', 40, b) for b in (1, 2, 1)),
        *(('count', order) for order in (3, 7, ENDLESS)),
    ]
    assert 5 <= servers.canceled_at[0] <= 100  # where the recorded goal was cancelled, not at its beginning


def test_a_number_that_was_changed_is_found(play: Play, bag: Path) -> None:
    options = ReplayOptions(rate=1000.0, tolerance=Tolerance(feedback=100))
    differences, _ = replayed(play, bag, options, wrong=1)
    assert differences == [
        "call 1 '/add' (a=40, b=1): sum 42, was 41",
        "call 2 '/add' (a=40, b=2): sum 43, was 42",
        "call 3 '/add' (a=40, b=1): sum 42, was 41",
        "goal 4 '/count' (order=3): result.sequence[1] 4, was 3",
    ]


def test_feedback_that_is_missing_is_found(play: Play, bag: Path) -> None:
    differences, _ = replayed(play, bag, FAST, skipped=1)
    assert "goal 4 '/count' (order=3): feedback 2 times, was 3 times" in differences


def test_a_server_that_is_not_there_is_told(play: Play, bag: Path) -> None:
    async def scenario() -> list[str]:
        async with goalwire.Node('player') as node:
            with Reader(bag) as read:
                only = Selection(services=Names(some=frozenset({'/add'})))
                options = ReplayOptions(only, rate=1000.0, timeout=0.2)
                return [str(each) for each in await Replay(node, read, options).run()]

    differences = play(scenario)
    assert len(differences) == 3
    assert all('the answer NoServerError' in each for each in differences)


@pytest.mark.also_on_dds
def test_a_bag_answers_in_the_place_of_the_servers(play: Play, bag: Path) -> None:
    """Requests that are recorded get their answers; others those that are left, in their order."""

    async def scenario() -> None:
        async with goalwire.Node('answers') as node, goalwire.Node('caller') as caller:
            with Reader(bag) as read:
                Answers(node, read, rate=1000.0)
            await ask(caller)
            add = caller.client(AddTwoInts, 'add')
            assert (await add.call(a=40, b=2, timeout=PATIENCE)).sum == 42
            with pytest.raises(ServerFailedError, match='no answer'):
                await add.call(a=0, b=0, timeout=PATIENCE)

    play(scenario)


def test_commands_answer_from_a_bag_and_compare_with_one(
    play: Play, bag: Path, ros2: CommandLine, begin: Begin, tmp_path: Path
) -> None:
    other = tmp_path / 'other'
    play(lambda: record(other, wrong=1))
    servers = begin('bag', 'play', str(bag), '--answer-calls', '--rate', '1000')
    servers.expect('answering from .*: /add, /count; Ctrl-C ends it')
    expect = ('--expect', '--services', '/add', '--rate', '1000')
    same = ros2('bag', 'play', str(bag), *expect)
    assert (same.code, same.out) == (0, '')
    assert 'sending 3 requests and 0 goals' in same.err
    assert 'everything is as it was recorded' in same.err
    changed = ros2('bag', 'play', str(other), *expect)
    assert (changed.code, changed.lines[0]) == (1, "call 1 '/add' (a=40, b=1): sum 41, was 42")
    assert '3 differences' in changed.err
    servers.send_signal(signal.SIGINT)
    assert servers.wait() == 0
    assert '6 requests and goals were answered' in servers.output


async def _by_player(node: goalwire.Node, bag: Reader) -> None:
    options = PlayOptions(rate=1.0, requests_from='service_introspection', goals_from='service_introspection')
    player = Player(node, bag, options)
    await player.play()
    assert (player.requested, player.goals_sent) == (3, 4)


@pytest.mark.also_on_dds
def test_the_player_sends_requests_and_goals(play: Play, bag: Path) -> None:
    sent: list[Servers] = []

    async def scenario() -> None:
        async with goalwire.Node('server') as server, goalwire.Node('player') as node:
            sent.append(Servers(server))
            with Reader(bag) as read:
                await _by_player(node, read)

    play(scenario)
    assert sorted(map(str, sent[0].requests)) == sorted(
        map(str, [*(('add', 40, b) for b in (1, 2, 1)), *(('count', n) for n in (3, 7, ENDLESS))])
    )
    assert len(sent[0].canceled_at) == 1


@pytest.mark.parametrize(
    ('tolerance', 'fields'),
    [
        (Tolerance(), ['header.stamp.sec', 'pose.position.x', 'pose.position.y']),
        (Tolerance(number=0.01), ['header.stamp.sec', 'pose.position.y']),
        (Tolerance(stamps=True), ['pose.position.x', 'pose.position.y']),
        (Tolerance(fields=('pose.position.*',)), ['header.stamp.sec']),
        (Tolerance(fields=('y', 'sec')), ['pose.position.x']),
    ],
    ids=str,
)
def test_what_may_differ(tolerance: Tolerance, fields: list[str]) -> None:
    now, was = PoseStamped(), PoseStamped()
    now.header.stamp.sec = 7
    now.pose.position.x, now.pose.position.y = 0.005, 0.5
    was.pose.position.y = 0.4
    differences = compare('pose', now, was, tolerance)
    assert [each.field for each in differences] == fields
    if 'pose.position.y' in fields:
        allowed = ' (tolerance 0.01)' if tolerance.number else ''
        assert str(differences[-1]) == f'pose: pose.position.y 0.5, was 0.4{allowed}'
