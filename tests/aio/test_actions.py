"""Actions: goals that are run, cancelled, refused, aborted, lost."""

from __future__ import annotations

import asyncio
import gc
import threading
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import TypeAlias

import pytest
from action_msgs.msg import GoalStatusArray
from example_interfaces.action import Fibonacci
from helpers.collector import Collector
from helpers.loops import LOOPS, Play, run, turns
from helpers.patience import PATIENCE
from helpers.processes import Program
from helpers.spinning import Spinner
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

import goalwire
from goalwire.aio.action.client import ActionClient, Run
from goalwire.errors import (
    ClosedError,
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalRefused,
    InvalidHandle,
    NoServerError,
    ServerLostError,
)
from goalwire.logging import add_sink
from goalwire.rules.goals.states import GoalStatus
from goalwire.transport.faults import Faults, Kill, Point

Taken: TypeAlias = goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]
Sent: TypeAlias = Run[Fibonacci.Result, Fibonacci.Feedback]
Client: TypeAlias = ActionClient[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]


class Counter:
    """An action server's handler that counts at once, or waits until it is cancelled (order 0)."""

    def __init__(self) -> None:
        self.began = asyncio.Event()
        self.ended: list[str] = []

    async def __call__(self, goal: Taken) -> Fibonacci.Result:
        if goal.request.order < 0:
            raise GoalAborted('below zero', result=Fibonacci.Result(sequence=[-1]))
        if goal.request.order == 0:
            await self._wait()
        for number in range(goal.request.order):
            goal.feedback(sequence=[number])
        return Fibonacci.Result(sequence=[goal.request.order])

    async def _wait(self) -> None:
        self.began.set()
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            self.ended.append('cancelled')
            raise


@asynccontextmanager
async def arena(handler: Counter | None = None) -> AsyncIterator[tuple[Client, Counter, goalwire.Node]]:
    """A server in one node, a client in another; gives the client, the handler and the server's node."""
    counter = handler or Counter()
    async with goalwire.Node('caller') as caller, goalwire.Node('server') as server:
        server.action_server(Fibonacci, 'count', counter, accept=lambda goal: goal.order < 1000)
        client = caller.action(Fibonacci, 'count')
        await client.wait_for_server(timeout=PATIENCE)
        yield client, counter, server


@pytest.mark.parametrize('loop', LOOPS)
def test_a_goal_gives_feedback_and_its_result(isolated: dict[str, str], loop: str) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, _):
            async with client.send(order=3, timeout=PATIENCE) as run_:
                heard = [list(feedback.sequence) async for feedback in run_.feedback]
                assert heard == [[0], [1], [2]]
                for _ in range(2):
                    assert list((await run_.result).sequence) == [3]
                assert run_.status is GoalStatus.SUCCEEDED
            assert list((await client.call(Fibonacci.Goal(order=1), timeout=PATIENCE)).sequence) == [1]

    run(scenario(), loop)


def test_feedback_needs_no_numpy(isolated: dict[str, str]) -> None:
    """The goal id in the message is an array of numpy's, whose import takes 80 ms and 20 MB."""
    program = """
        import asyncio
        import sys
        import goalwire
        from example_interfaces.action import Fibonacci

        async def count(goal):
            goal.feedback(sequence=[1])
            return Fibonacci.Result()

        async def main():
            async with goalwire.Node('light') as node:
                node.action_server(Fibonacci, 'count', count)
                client = node.action(Fibonacci, 'count')
                await client.wait_for_server()
                async with client.send(order=1) as run:
                    print([list(feedback.sequence) async for feedback in run.feedback])
                print('numpy' in sys.modules)

        asyncio.run(main())
    """
    with Program(program, env=isolated) as running:
        assert running.succeed().splitlines() == ['[[1]]', 'False']


@pytest.mark.also_on_dds
def test_who_iterates_over_the_feedback_hears_all_of_it_before_the_result(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, _):
            for _ in range(20):
                order: list[object] = []
                async with client.send(order=5, timeout=PATIENCE) as run_:

                    async def listen(run_: Sent = run_, order: list[object] = order) -> None:
                        order += [feedback.sequence[0] async for feedback in run_.feedback]
                        order.append('no more')

                    async with asyncio.TaskGroup() as tasks:
                        tasks.create_task(listen())
                        await run_.result
                        order.append('result')
                assert order == [0, 1, 2, 3, 4, 'no more', 'result']

    play(scenario)


def test_an_aborted_goal_raises_with_its_result_and_a_failing_handler_aborts(play: Play) -> None:
    records: Collector[str] = Collector()

    async def fail(_: Taken) -> Fibonacci.Result:
        raise KeyError('joint')

    async def scenario() -> None:
        async with arena() as (client, _, server):
            with pytest.raises(
                GoalAborted, match=r"action '/count' of node '/server': the goal was aborted"
            ) as e:
                await client.call(order=-1, timeout=PATIENCE)
            assert list(e.value.result.sequence) == [-1]
            server.action_server(Fibonacci, 'fails', fail)
            server.action_server(Fibonacci, 'wrong', _nothing)  # type: ignore[arg-type]
            for name in ('fails', 'wrong'):
                with pytest.raises(GoalAborted) as e:
                    await server.action(Fibonacci, name).call(timeout=PATIENCE)
                assert list(e.value.result.sequence) == []

    with add_sink(lambda record: records(record.message)):
        play(scenario)
    said = '\n'.join(records.items)
    assert "Action '/count': the goal was aborted: below zero" in said
    assert "Action '/fails': its handler failed; the goal is aborted\nTraceback" in said
    wrong = 'its handler returned NoneType, not Fibonacci_Result'
    assert f"Action '/wrong': the goal was aborted: {wrong}" in said


@pytest.mark.also_on_dds
def test_a_plain_client_reads_the_result_of_an_aborted_goal(play: Play) -> None:
    """The reason follows the message: see docs/adr/009."""

    async def fail(_: Taken) -> Fibonacci.Result:
        raise KeyError('joint')

    async def scenario() -> None:
        async with arena() as (_, _, server), goalwire.Node('asker') as asker:
            server.action_server(Fibonacci, 'fails', fail)
            async with asker.action(Fibonacci, 'fails').send(timeout=PATIENCE) as run_:
                with pytest.raises(GoalAborted, match="KeyError: 'joint'"):
                    await run_.result
            plain = asker.client(Fibonacci.Impl.GetResultService, 'fails/_action/get_result')
            answer = await plain.call(goal_id=UUID(uuid=list(run_.goal_id)), timeout=PATIENCE)
            assert (answer.status, list(answer.result.sequence)) == (GoalStatus.ABORTED, [])

    play(scenario)


async def _nothing(_: Taken) -> None:
    return None


def test_a_goal_that_is_not_accepted_is_refused_on_entering(play: Play) -> None:
    async def scenario() -> None:
        async def judge(goal: Fibonacci.Goal) -> bool:
            await asyncio.sleep(0)
            return goal.order != 7

        async def fail(_: Fibonacci.Goal) -> bool:
            raise KeyError('judge')

        async with arena() as (client, counter, server):
            with pytest.raises(GoalRefused, match="'/count' of node '/server': the server refused the goal"):
                await client.send(order=1000, timeout=PATIENCE).__aenter__()
            server.action_server(Fibonacci, 'judged', counter, accept=judge)
            judged = server.action(Fibonacci, 'judged')
            assert list((await judged.call(order=6, timeout=PATIENCE)).sequence) == [6]
            with pytest.raises(GoalRefused):
                await judged.call(order=7, timeout=PATIENCE)
            server.action_server(Fibonacci, 'unjudged', counter, accept=fail)
            with pytest.raises(GoalRefused):
                await server.action(Fibonacci, 'unjudged').call(timeout=PATIENCE)

    play(scenario)


@pytest.mark.parametrize('loop', LOOPS)
def test_leaving_the_block_cancels_the_goal_and_waits_for_its_end(
    isolated: dict[str, str], loop: str
) -> None:
    async def scenario() -> None:
        async with arena() as (client, counter, _):
            async with client.send(order=0, timeout=PATIENCE) as run_:
                await counter.began.wait()
            assert counter.ended == ['cancelled']
            assert run_.status is GoalStatus.CANCELED
            with pytest.raises(GoalCanceled):
                await run_.result

    run(scenario(), loop)


async def _call_until(event: asyncio.Event, client: Client) -> None:
    """Send a goal, and let a deadline end the call at `event`."""

    async def expire() -> None:
        await event.wait()
        limit.reschedule(0.0)

    async with asyncio.timeout(None) as limit, asyncio.TaskGroup() as group:
        group.create_task(expire())
        await client.call(order=0)


def test_cancelling_the_task_cancels_the_goal(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, counter, _):
            calling = asyncio.create_task(client.call(order=0))
            await counter.began.wait()
            calling.cancel()
            with pytest.raises(asyncio.CancelledError):
                await calling
            assert counter.ended == ['cancelled']
            counter.began.clear()
            with pytest.raises(TimeoutError):
                await _call_until(counter.began, client)
            assert counter.ended == ['cancelled'] * 2

    play(scenario)


def test_a_goal_is_cancelled_from_within_and_its_handler_may_send_a_last_result(play: Play) -> None:
    async def scenario() -> None:
        async def tidy(_: Taken) -> Fibonacci.Result:
            began.set()
            try:
                await asyncio.Event().wait()
            except asyncio.CancelledError:
                await turns()
            return Fibonacci.Result(sequence=[1, 2])

        began = asyncio.Event()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'count', tidy)
            async with node.action(Fibonacci, 'count').send(timeout=PATIENCE) as run_:
                await began.wait()
                assert await run_.cancel(timeout=PATIENCE)
                assert [feedback async for feedback in run_.feedback] == []
                with pytest.raises(GoalCanceled, match='the goal was cancelled') as e:
                    await run_.result
                assert list(e.value.result.sequence) == [1, 2]
                assert not await run_.cancel(timeout=PATIENCE)

    play(scenario)


def test_the_deadline_ends_feedback_and_result_and_then_the_goal(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, counter, _):
            start = time.monotonic()
            async with client.send(order=0, timeout=0.05) as run_:
                assert [feedback async for feedback in run_.feedback] == []
                assert time.monotonic() - start >= 0.05
                with pytest.raises(DeadlineError, match="of node '/server': no answer came in time") as e:
                    await run_.result
                assert e.value.name == '/count'
                with pytest.raises(DeadlineError, match='no answer came in time'):
                    await run_.wait(timeout=0.01)
                assert not counter.ended
                assert await run_.cancel(timeout=PATIENCE)
                with pytest.raises(GoalCanceled):
                    await run_.wait(timeout=PATIENCE)
            assert counter.ended == ['cancelled']

    play(scenario)


def test_the_deadline_covers_waiting_for_server_and_acceptance(play: Play) -> None:
    async def scenario() -> None:
        async def hesitate(_: Fibonacci.Goal) -> bool:
            await decided.wait()
            return True

        decided = asyncio.Event()
        latched = goalwire.QoS(depth=100, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
        async with goalwire.Node('node') as node:
            client = node.action(Fibonacci, 'count')
            with pytest.raises(NoServerError, match="action '/count': no server came"):
                await client.call(timeout=0.02)
            statuses = node.subscription(GoalStatusArray, 'count/_action/status', qos=latched)
            node.action_server(Fibonacci, 'count', Counter(), accept=hesitate)
            with pytest.raises(DeadlineError):
                await client.call(order=0, timeout=0.05)
            decided.set()  # accepted after all: it is cancelled
            async for array in statuses:
                if [entry.status for entry in array.status_list] == [GoalStatus.CANCELED]:
                    break

    play(scenario)


def test_a_server_that_goes_away_loses_the_goal_at_once(play: Play) -> None:
    async def scenario() -> None:
        counter = Counter()
        gone = asyncio.Event()

        async def serve() -> None:
            async with goalwire.Node('server') as server:
                server.action_server(Fibonacci, 'count', counter)
                await gone.wait()

        async with goalwire.Node('caller') as caller:
            serving = asyncio.create_task(serve())
            start = time.monotonic()
            async with caller.action(Fibonacci, 'count').send(order=0, timeout=PATIENCE) as run_:
                await counter.began.wait()
                gone.set()
                assert [feedback async for feedback in run_.feedback] == []
                with pytest.raises((ServerLostError, GoalAborted)):  # the server says so if it still can
                    await run_.result
            assert time.monotonic() - start < 5
            await serving
            assert counter.ended == ['cancelled']

    play(scenario)


def test_closing_ends_what_runs(play: Play) -> None:
    async def scenario() -> None:
        counter = Counter()
        async with goalwire.Node('node') as node, goalwire.Node('other') as other:
            server = node.action_server(Fibonacci, 'count', counter)
            client = other.action(Fibonacci, 'count')
            async with client.send(order=0, timeout=PATIENCE) as run_:
                await counter.began.wait()
                server.close()
                server.close()
                with pytest.raises(GoalAborted):
                    await run_.result
            node.action_server(Fibonacci, 'count', counter)
            async with client.send(order=0, timeout=PATIENCE) as run_:
                client.close()
                with pytest.raises(InvalidHandle):
                    await run_.result
            with pytest.raises(InvalidHandle):
                await client.call(order=1)

    play(scenario)


def test_a_task_that_is_cancelled_before_its_goal_is_accepted_cancels_it_when_it_is(play: Play) -> None:
    async def scenario() -> None:
        async def hesitate(_: Fibonacci.Goal) -> bool:
            asked.set()
            await decided.wait()
            return True

        asked, decided = asyncio.Event(), asyncio.Event()
        counter = Counter()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'count', counter, accept=hesitate)
            run_ = node.action(Fibonacci, 'count').send(order=0)
            entering = asyncio.create_task(run_.__aenter__())
            await asked.wait()
            entering.cancel()
            await turns()
            assert not entering.done()
            decided.set()
            with pytest.raises(asyncio.CancelledError):
                await entering
            assert run_.status is GoalStatus.CANCELED
            assert counter.ended == ['cancelled'] * counter.began.is_set()

    play(scenario)


def test_a_goal_that_does_not_end_when_it_is_cancelled_is_waited_for_as_long_as_was_said(play: Play) -> None:
    records: Collector[str] = Collector()

    async def scenario() -> None:
        async def stubborn(_: Taken) -> Fibonacci.Result:
            began.set()
            while not done.is_set():
                with suppress(asyncio.CancelledError):
                    await done.wait()
            return Fibonacci.Result()

        began, done = asyncio.Event(), asyncio.Event()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'count', stubborn)
            async with node.action(Fibonacci, 'count').send(timeout=PATIENCE, grace=0.05):
                await began.wait()
            done.set()

    with add_sink(lambda record: records(record.message)):
        play(scenario)
    assert [text for text in records.items if 'a goal that was cancelled did not end' in text]


def test_the_late_failure_of_a_goal_that_was_left_is_no_surprise(
    play: Play, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its result fails, here as the client is closed, when nobody asks for it any more."""

    async def scenario() -> None:
        async def stubborn(_: Taken) -> Fibonacci.Result:
            began.set()
            while not done.is_set():
                with suppress(asyncio.CancelledError):
                    await done.wait()
            return Fibonacci.Result()

        began, done = asyncio.Event(), asyncio.Event()
        async with goalwire.Node('node') as node:
            node.action_server(Fibonacci, 'count', stubborn)
            client = node.action(Fibonacci, 'count')
            async with client.send(timeout=PATIENCE, grace=0.01):
                await began.wait()
            client.close()
            gc.collect()
            done.set()

    play(scenario)
    assert 'never retrieved' not in capsys.readouterr().err


def test_a_server_that_is_lost_under_a_goal_nobody_waits_for_any_more_is_no_surprise(
    play: Play, capsys: pytest.CaptureFixture[str]
) -> None:
    """The task was cancelled before the goal was accepted, so that nobody can look at its result."""

    async def scenario() -> None:
        async def hesitate(_: Fibonacci.Goal) -> bool:
            asked.set()
            await decided.wait()
            return True

        asked, decided = asyncio.Event(), asyncio.Event()
        async with goalwire.Node('caller') as caller, goalwire.Node('server') as server:
            server.action_server(Fibonacci, 'count', Counter(), accept=hesitate)
            client = caller.action(Fibonacci, 'count')
            entering = asyncio.create_task(client.call(order=0, timeout=PATIENCE, grace=PATIENCE))
            await asked.wait()
            lost = faults.add(Kill('server', Point.RESULT_READY, '/count'))
            entering.cancel()
            await turns()
            decided.set()
            with pytest.raises(asyncio.CancelledError):
                await entering
            assert lost.struck
            del entering
            gc.collect()

    with Faults() as faults:
        play(scenario)
    assert 'never retrieved' not in capsys.readouterr().err


def test_a_goal_of_a_server_that_cancels_none_goes_on(play: Play) -> None:
    records: Collector[str] = Collector()
    done = threading.Event()

    def execute(goal: ServerGoalHandle) -> Fibonacci.Result:
        assert done.wait(PATIENCE)
        goal.succeed()
        return Fibonacci.Result()

    async def scenario() -> None:
        async with (
            goalwire.Node('caller') as caller,
            caller.action(Fibonacci, 'stubborn').send(timeout=PATIENCE),
        ):
            pass
        done.set()

    with Context() as context, add_sink(lambda record: records(record.message)):
        node = Node('server', context=context)
        with ActionServer(node, Fibonacci, 'stubborn', execute):  # as rclpy's do by default
            executor = MultiThreadedExecutor(2, context=context)
            executor.add_node(node)
            with Spinner(executor):
                play(scenario)
            executor.shutdown()
        node.destroy_node()
    assert "Action '/stubborn': the server does not cancel the goal: it goes on" in records.items


def test_a_run_is_entered_once_and_asked_in_its_block(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, _):
            run_ = client.send(order=1)
            with pytest.raises(ClosedError, match='in its block'):
                await run_.result
            async with run_:
                await run_.result
                with pytest.raises(ClosedError, match='entered before'):
                    await run_.__aenter__()
            with pytest.raises(TypeError, match='expected'):
                await client.call(Fibonacci.Result(), timeout=PATIENCE)  # type: ignore[arg-type]

    play(scenario)


def test_a_goal_that_was_not_sent_is_warned_of(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            with pytest.warns(RuntimeWarning, match="a goal for '/count' was not sent"):
                node.action(Fibonacci, 'count').send(order=1)

    play(scenario)


def test_many_goals_run_beside_each_other(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, _), asyncio.TaskGroup() as group:
            tasks = [group.create_task(client.call(order=order, timeout=PATIENCE)) for order in range(1, 20)]
        assert [list(task.result().sequence) for task in tasks] == [[order] for order in range(1, 20)]

    play(scenario)
