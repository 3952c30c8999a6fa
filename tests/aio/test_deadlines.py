"""Times that calls and goals of the asyncio API have by default, and requests that are sent again."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import Play
from std_srvs.srv import Trigger

import goalwire
from goalwire.errors import DeadlineError, NoServerError, RefusedError, ServerFailedError, ServerLostError
from goalwire.testing import VirtualClock

from .conftest import ON_MEMORY


async def never(_: object) -> Trigger.Response:
    await asyncio.Event().wait()
    return Trigger.Response()


@ON_MEMORY
def test_the_nearest_default_counts(play: Play, clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_CALL_TIMEOUT', '0.01')

    async def lasts(client: goalwire.Client[Trigger.Request, Trigger.Response], **given: float) -> float:
        with pytest.raises(DeadlineError) as e:
            await client.call(None, **given)
        return e.value.waited

    async def scenario() -> None:
        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand', call_timeout=0.1) as hand:
            lamp.service(Trigger, 'hang', never)
            of_process = lamp.client(Trigger, 'hang')
            await of_process.wait_for_server(timeout=9.0)
            of_node = hand.client(Trigger, 'hang')
            of_client = hand.client(Trigger, 'hang', timeout=0.2)
            assert await lasts(of_process) == pytest.approx(0.01)
            assert await lasts(of_node) == pytest.approx(0.1)
            assert await lasts(of_client) == pytest.approx(0.2)
            assert await lasts(of_client, timeout=0.02) == pytest.approx(0.02)
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.05):
                    await of_process.call(timeout=math.inf)
            assert len(of_process._core.timed) == 0

    play(scenario)


@ON_MEMORY
def test_a_default_of_the_node_is_for_the_acceptance_of_goals_not_for_their_results(
    play: Play, clock: VirtualClock
) -> None:
    async def move(_: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        await asyncio.sleep(0.2)
        return Fibonacci.Result(sequence=[1])

    async def judge(_: Fibonacci.Goal) -> bool:
        await asyncio.Event().wait()
        return True

    async def scenario() -> None:
        async with goalwire.Node('arm') as arm, goalwire.Node('hand', call_timeout=0.1) as hand:
            arm.action_server(Fibonacci, 'move', move)
            arm.action_server(Fibonacci, 'ponder', move, accept=judge)
            client, pondering = hand.action(Fibonacci, 'move'), hand.action(Fibonacci, 'ponder')
            await client.wait_for_server(timeout=9.0)
            await pondering.wait_for_server(timeout=9.0)
            assert list((await client.call(order=1)).sequence) == [1]
            with pytest.raises(
                DeadlineError, match="action '/ponder' of node '/arm': no answer came in time"
            ):
                await pondering.call(order=1)
            with pytest.raises(NoServerError):
                await hand.action(Fibonacci, 'nosuch').call(order=1)
            hasty = hand.action(Fibonacci, 'move', timeout=0.1)
            with pytest.raises(DeadlineError):
                await hasty.call(order=1)
            assert list((await hasty.call(order=1, timeout=9.0)).sequence) == [1]
            assert pondering._core.goal_requests.timed == {}

    play(scenario)


def test_a_cancelled_task_that_waits_for_acceptance_leaves_no_goal(
    play: Play, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        asked, answer, over, cancelled = (asyncio.Event() for _ in range(4))

        async def move(_: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
            await asyncio.Event().wait()
            return Fibonacci.Result()

        async def judge(_: Fibonacci.Goal) -> bool:
            asked.set()
            await answer.wait()
            over.set()
            return True

        async with goalwire.Node('arm') as arm, goalwire.Node('hand') as hand:
            arm.action_server(Fibonacci, 'move', move, accept=judge)
            client = hand.action(Fibonacci, 'move')
            calling = asyncio.create_task(client.call(order=1, grace=0.05))
            await asked.wait()
            calling.cancel()
            with pytest.raises(asyncio.CancelledError):
                await calling
            assert client._core.goal_requests.timed == {}
            assert len(client._core.goal_requests.late) == 1
            loop, cancel = asyncio.get_running_loop(), client._core.cancel_goal

            def told(*given: Any, **more: Any) -> Any:
                loop.call_soon_threadsafe(cancelled.set)
                return cancel(*given, **more)

            monkeypatch.setattr(client._core, 'cancel_goal', told)
            answer.set()
            await over.wait()
            await cancelled.wait()
            assert client._core.goal_requests.late == {}

    play(scenario)


def test_a_client_may_send_requests_again(play: Play) -> None:
    records: list[goalwire.CallAttempt] = []

    async def scenario() -> None:
        requests: list[Trigger.Request] = []
        heard = asyncio.Event()

        def hear(record: goalwire.CallAttempt) -> None:
            records.append(record)
            if record.error is None:
                heard.set()

        async def third_time_lucky(request: Trigger.Request) -> Trigger.Response:
            requests.append(request)
            if len(requests) < 3:
                await asyncio.Event().wait()
            return Trigger.Response(success=True)

        async with goalwire.Node('lamp') as lamp, goalwire.Node('hand') as hand:
            lamp.service(Trigger, 'switch', third_time_lucky)
            retry = goalwire.Retry(timeout=0.05, first_delay=0.001, on_attempt=hear)
            client = hand.client(Trigger, 'switch', retry=retry)
            assert (await client.call(timeout=9.0)).success
            assert len(requests) == 3
            await heard.wait()
        assert [record.number for record in records] == [1, 2, 3]
        assert [type(record.error) for record in records] == [DeadlineError, DeadlineError, type(None)]
        assert {record.peers for record in records} == {('/lamp',)}

    play(scenario)


def test_a_handler_may_call_its_own_node_and_a_circle_ends_by_its_deadline(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('node') as node:
            inner = node.client(Trigger, 'inner', timeout=9.0)
            circle = node.client(Trigger, 'circle', timeout=0.05)

            async def ask(_: Trigger.Request) -> Trigger.Response:
                return await inner.call()

            async def ask_itself(_: Trigger.Request) -> Trigger.Response:
                with pytest.raises(DeadlineError):
                    await circle.call()
                return Trigger.Response(message='a circle')

            node.service(Trigger, 'inner', lambda _: Trigger.Response(success=True))
            node.service(Trigger, 'outer', ask)
            node.service(Trigger, 'circle', ask_itself, concurrent=False)
            assert (await node.client(Trigger, 'outer').call(timeout=9.0)).success
            assert (await circle.call(timeout=9.0)).message == 'a circle'

    play(scenario)


def test_errors_of_calls_are_one_hierarchy() -> None:
    for kind in (DeadlineError, NoServerError, RefusedError, ServerFailedError, ServerLostError):
        assert issubclass(kind, goalwire.CallError)
        assert issubclass(kind, TimeoutError) is (kind in (DeadlineError, NoServerError))
    assert issubclass(goalwire.GoalRefused, RefusedError)
