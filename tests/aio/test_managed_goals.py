"""Goals, managed: policies, hooks, heartbeats, cancelling many, clients that go."""

from __future__ import annotations

import asyncio
from typing import TypeAlias

import pytest
from action_msgs.msg import GoalStatusArray
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.loops import Play

import goalwire
from goalwire.errors import GoalAborted, GoalRefused, NoServerError, ServerStuckError
from goalwire.logging import add_sink
from goalwire.rules.goals.cancel_requests import CancelCode
from goalwire.rules.goals.policy import OnClientLost
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.time import Time
from goalwire.testing import VirtualClock

from .conftest import ON_MEMORY

Taken: TypeAlias = goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]
Running: TypeAlias = goalwire.Run[Fibonacci.Result, Fibonacci.Feedback]
LATCHED = goalwire.QoS(depth=100, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
IN_TIME = 5.0


class Jobs:
    """A handler that writes down what it runs, each until the test lets it go on or cancels it."""

    def __init__(self) -> None:
        self.began: asyncio.Queue[int] = asyncio.Queue()
        self.ended: list[str] = []
        self.one_has_ended = asyncio.Event()
        self._go_on: dict[int, asyncio.Event] = {}

    def finish(self, order: int) -> None:
        """Let a job come to its end."""
        self._go_on[order].set()

    async def __call__(self, goal: Taken) -> Fibonacci.Result:
        order = goal.request.order
        self._go_on[order] = asyncio.Event()
        self.began.put_nowait(order)
        try:
            await self._go_on[order].wait()
        except asyncio.CancelledError:
            self.ended.append(f'{order} cancelled')
            self.one_has_ended.set()
            raise
        self.ended.append(f'{order} done')
        return Fibonacci.Result(sequence=[order])


async def settled(run: Running) -> str:
    """Wait for a run's end; return what came of it."""
    try:
        return f'done {list((await run.result).sequence)}'
    except goalwire.CallError as error:
        return type(error).__name__


# -- policies ----------------------------------------------------------------------------------------------


def test_a_server_of_single_goals_refuses_others_meanwhile(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.single())
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME) as run:
                assert await jobs.began.get() == 1
                with pytest.raises(GoalRefused):
                    await client.call(order=2, timeout=IN_TIME)
                jobs.finish(1)
                assert await settled(run) == 'done [1]'
            async with client.send(order=3, timeout=IN_TIME):
                assert await jobs.began.get() == 3

    play(scenario)


def test_a_server_of_parallel_goals_runs_that_many(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.parallel(2))
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME), client.send(order=2, timeout=IN_TIME):
                assert {await jobs.began.get(), await jobs.began.get()} == {1, 2}
                with pytest.raises(GoalRefused):
                    await client.call(order=3, timeout=IN_TIME)

    play(scenario)


def test_a_new_goal_preempts_the_one_that_runs(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.preempt())
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME) as first:
                assert await jobs.began.get() == 1
                async with client.send(order=2, timeout=IN_TIME) as second:
                    assert await settled(first) == 'GoalCanceled'
                    assert await jobs.began.get() == 2
                    assert jobs.ended == ['1 cancelled']
                    jobs.finish(2)
                    assert await settled(second) == 'done [2]'

    play(scenario)


def test_queued_goals_run_in_turn_and_one_that_is_cancelled_never_runs(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.queue(2))
            client = node.action(Fibonacci, 'job')
            first, second, third = (client.send(order=order, timeout=IN_TIME) for order in (1, 2, 3))
            async with first, second, third:
                assert await jobs.began.get() == 1
                with pytest.raises(GoalRefused):
                    await client.call(order=4, timeout=IN_TIME)
                assert await second.cancel(timeout=IN_TIME)
                assert await settled(second) == 'GoalCanceled'
                jobs.finish(1)
                assert await jobs.began.get() == 3
                jobs.finish(3)
                assert [await settled(run) for run in (first, third)] == ['done [1]', 'done [3]']
            assert jobs.ended == ['1 done', '3 done']

    play(scenario)


@pytest.mark.parametrize('policy', [goalwire.preempt(), goalwire.queue(9)])
def test_of_goals_that_have_ended_in_whatever_way_nothing_is_left(
    play: Play, policy: goalwire.GoalPolicy
) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            server = node.action_server(Fibonacci, 'job', jobs, policy=policy, on_client_lost='abort')
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME) as first:
                await jobs.began.get()
                async with (
                    client.send(order=2, timeout=IN_TIME),
                    client.send(order=3, timeout=IN_TIME) as last,
                ):
                    await client.cancel_all_goals(timeout=IN_TIME)
                    assert await settled(last) == await settled(first) == 'GoalCanceled'
            counted = server.statistics().goals
            assert (counted.canceled, counted.running, counted.waiting, counted.active) == (3, 0, 0, 0)
            kept = server._core.reactor.goals.values()
            assert [(goal.handle, goal.execution) for goal in kept] == [(None, None)] * 3

    play(scenario)


def test_a_queued_goal_is_shown_as_accepted_then_as_executing(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        seen: list[int] = []
        async with goalwire.Node('node') as node:
            statuses = node.subscription(GoalStatusArray, 'job/_action/status', qos=LATCHED)
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.queue(1))
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME), client.send(order=2, timeout=IN_TIME) as run:
                async for array in statuses:
                    seen += [
                        entry.status
                        for entry in array.status_list
                        if bytes(entry.goal_info.goal_id.uuid) == run.goal_id and entry.status not in seen
                    ]
                    if seen == [GoalStatus.ACCEPTED]:
                        jobs.finish(await jobs.began.get())
                    if seen[-1:] == [GoalStatus.EXECUTING]:
                        break
        assert seen == [GoalStatus.ACCEPTED, GoalStatus.EXECUTING]

    play(scenario)


# -- failures ----------------------------------------------------------------------------------------------


def test_why_a_handler_failed_reaches_the_client_and_the_hook(play: Play) -> None:
    failures: list[tuple[int, str]] = []

    async def fail(goal: Taken) -> Fibonacci.Result:
        raise KeyError('joint')

    def note(goal: Taken, error: Exception) -> Fibonacci.Result:
        failures.append((goal.request.order, repr(error)))
        return Fibonacci.Result(sequence=[7])

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', fail, on_failure=note)
            with pytest.raises(GoalAborted, match=r"the goal was aborted: KeyError: 'joint'; waited") as e:
                await node.action(Fibonacci, 'job').call(order=3, timeout=IN_TIME)
            assert list(e.value.result.sequence) == [7]

    play(scenario)
    assert failures == [(3, "KeyError('joint')")]


def test_what_a_handler_says_when_it_aborts_reaches_the_client_but_not_the_hook(play: Play) -> None:
    async def abort(_: Taken) -> Fibonacci.Result:
        raise GoalAborted('the arm is stuck: ü', result=Fibonacci.Result(sequence=[1]))

    def note(_: Taken, error: Exception) -> None:
        raise AssertionError(error)

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', abort, on_failure=note)
            with pytest.raises(GoalAborted, match='the goal was aborted: the arm is stuck: ü; waited') as e:
                await node.action(Fibonacci, 'job').call(timeout=IN_TIME)
            assert list(e.value.result.sequence) == [1]

    play(scenario)


def test_a_hook_that_fails_is_logged_and_the_goal_aborted_all_the_same(play: Play) -> None:
    records: Collector[str] = Collector()

    async def fail(_: Taken) -> Fibonacci.Result:
        raise KeyError('joint')

    def fail_too(_: Taken, _error: Exception) -> None:
        raise ValueError('hook')

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', fail, on_failure=fail_too)
            with pytest.raises(GoalAborted, match='KeyError'):
                await node.action(Fibonacci, 'job').call(timeout=IN_TIME)

    with add_sink(lambda record: records(record.message)):
        play(scenario)
    assert "Action 'job': on_failure failed itself: ValueError: hook" in records.items


# -- cancelling many ---------------------------------------------------------------------------------------


def test_all_goals_are_cancelled_whoever_has_sent_them(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node, goalwire.Node('other') as other:
            node.action_server(Fibonacci, 'job', jobs)
            mine, yours = node.action(Fibonacci, 'job'), other.action(Fibonacci, 'job')
            async with mine.send(order=1, timeout=IN_TIME) as a, yours.send(order=2, timeout=IN_TIME) as b:
                answer = await yours.cancel_all_goals(timeout=IN_TIME)
                assert answer.code is CancelCode.NONE
                assert set(answer.goals) == {a.goal_id, b.goal_id}
                assert [await settled(run) for run in (a, b)] == ['GoalCanceled'] * 2
            assert await mine.cancel_all_goals(timeout=IN_TIME) == (CancelCode.NONE, ())

    play(scenario)


def test_goals_are_cancelled_that_were_accepted_before_a_time(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs)
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1, timeout=IN_TIME) as before:
                await jobs.began.get()
                between = node.clock.now()
                async with client.send(order=2, timeout=IN_TIME) as later:
                    await jobs.began.get()
                    answer = await client.cancel_goals_before(between, timeout=IN_TIME)
                    assert answer.goals == (before.goal_id,)
                    jobs.finish(2)
                    assert [await settled(run) for run in (before, later)] == ['GoalCanceled', 'done [2]']

    play(scenario)


def test_cancelling_many_needs_a_server_and_a_time(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            client = node.action(Fibonacci, 'job')
            with pytest.raises(NoServerError):
                await client.cancel_all_goals(timeout=0.01)
            node.action_server(Fibonacci, 'job', Jobs())
            with pytest.raises(ValueError, match='cancel_all_goals cancels all'):
                await client.cancel_goals_before(Time(), timeout=IN_TIME)

    play(scenario)


# -- heartbeats --------------------------------------------------------------------------------------------


def test_a_server_that_is_silent_too_long_counts_as_stuck(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs)
            async with node.action(Fibonacci, 'job').send(heartbeat=0.05) as run:
                assert [feedback async for feedback in run.feedback] == []
                with pytest.raises(ServerStuckError, match=r'no sign of life for 0\.05 s; waited') as e:
                    await run.result
                assert (e.value.name, e.value.peers) == ('/job', ('/node',))
            async with asyncio.timeout(IN_TIME):
                await jobs.one_has_ended.wait()  # it hears of it, should it wake up
            assert jobs.ended == ['0 cancelled']

    play(scenario)


@ON_MEMORY
def test_a_server_that_gives_feedback_is_not_stuck(play: Play, clock: VirtualClock) -> None:
    async def work(goal: Taken) -> Fibonacci.Result:
        for step in range(12):
            await asyncio.sleep(0.05)
            goal.feedback(sequence=[step])
        return Fibonacci.Result(sequence=[6])

    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', work)
            result = await node.action(Fibonacci, 'job').call(heartbeat=0.4, timeout=IN_TIME)
            assert list(result.sequence) == [6]

    play(scenario)


@ON_MEMORY
def test_a_goal_that_waits_for_its_turn_is_not_stuck(play: Play, clock: VirtualClock) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'job', jobs, policy=goalwire.queue(1))
            client = node.action(Fibonacci, 'job')
            async with client.send(order=1) as first, client.send(order=2, heartbeat=0.3) as second:
                await asyncio.sleep(0.4)
                assert second.status is GoalStatus.ACCEPTED
                jobs.finish(1)
                assert await settled(first) == 'done [1]'
                assert await settled(second) == 'ServerStuckError'  # now it runs, and is silent

    play(scenario)


def test_a_heartbeat_is_a_time_above_zero(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            with pytest.raises(ValueError, match='a heartbeat is a time above 0 s, not 0'):
                node.action(Fibonacci, 'job').send(heartbeat=0.0)

    play(scenario)


# -- clients that go ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('choice', 'status'), [('cancel', GoalStatus.CANCELED), ('abort', GoalStatus.ABORTED)]
)
def test_the_goal_of_a_client_that_has_gone_ends(
    play: Play, choice: OnClientLost, status: GoalStatus
) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('server') as server:
            statuses = server.subscription(GoalStatusArray, 'job/_action/status', qos=LATCHED)
            server.action_server(Fibonacci, 'job', jobs, on_client_lost=choice)
            async with goalwire.Node('caller') as caller:
                client = caller.action(Fibonacci, 'job')
                run = client.send(order=1, timeout=IN_TIME)
                await run.__aenter__()
                await jobs.began.get()
                client.close()
            async for array in statuses:
                if [entry.status for entry in array.status_list] == [status]:
                    break
            assert jobs.ended == ['1 cancelled']

    play(scenario)


def test_the_goal_of_a_client_that_has_gone_is_kept_by_default(play: Play) -> None:
    async def scenario() -> None:
        jobs = Jobs()
        async with goalwire.Node('server') as server:
            server.action_server(Fibonacci, 'job', jobs)
            async with goalwire.Node('caller') as caller:
                client = caller.action(Fibonacci, 'job')
                run = client.send(order=1, timeout=IN_TIME)
                await run.__aenter__()
                await jobs.began.get()
                client.close()
                other = server.action(Fibonacci, 'job')
                assert (await other.cancel_all_goals(timeout=IN_TIME)).goals == (run.goal_id,)

    play(scenario)
