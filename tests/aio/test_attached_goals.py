"""Goals that outlive their senders: ids of one's own, kept goals, attaching to goals, probing them."""

from __future__ import annotations

import asyncio
import uuid
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import TypeAlias

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import Play, turns
from helpers.spinning import Spinner
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node

import goalwire
from goalwire.aio.action.client import ActionClient
from goalwire.errors import (
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalIdTaken,
    GoalRefused,
    InvalidHandle,
    ServerLostError,
    ServerStuckError,
)
from goalwire.rules.goals.states import GoalStatus

Taken: TypeAlias = goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]
Handled: TypeAlias = ServerGoalHandle[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
Client: TypeAlias = ActionClient[Fibonacci.Goal, Fibonacci.Result, Fibonacci.Feedback]
ID = uuid.UUID('6ba7b810-9dad-41d1-80b4-00c04fd430c8')
OTHER = uuid.UUID('6ba7b811-9dad-41d1-80b4-00c04fd430c8')
IN_TIME = 10.0


class Job:
    """A handler that counts its executions; each goes on when told to, and says how it ended."""

    def __init__(self) -> None:
        self.executed: list[bytes] = []
        self.began = asyncio.Event()
        self.go_on = asyncio.Event()
        self.is_cancelled = asyncio.Event()
        self.says = asyncio.Queue[int]()

    async def __call__(self, goal: Taken) -> Fibonacci.Result:
        self.executed.append(goal.goal_id)
        self.began.set()
        try:
            while (number := await self.says.get()) >= 0:
                goal.feedback(sequence=[number])
        except asyncio.CancelledError:
            self.is_cancelled.set()
            raise
        return Fibonacci.Result(sequence=[goal.request.order])

    def finish(self) -> None:
        """Let the goal succeed."""
        self.says.put_nowait(-1)


@asynccontextmanager
async def arena() -> AsyncIterator[tuple[Client, Client, Job]]:
    """A server in one node, and a client in each of two others."""
    job = Job()
    async with (
        goalwire.Node('server') as server,
        goalwire.Node('first') as first,
        goalwire.Node('second') as second,
    ):
        server.action_server(Fibonacci, 'job', job)
        clients = first.action(Fibonacci, 'job'), second.action(Fibonacci, 'job')
        for client in clients:
            await client.wait_for_server(timeout=IN_TIME)
        yield *clients, job


@pytest.mark.also_on_dds
def test_another_client_attaches_to_a_kept_goal(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            async with first.send(order=7, goal_id=ID, keep=True, timeout=IN_TIME) as sent:
                assert sent.goal_id == ID.bytes
                await job.began.wait()
            async with second.attach(ID, timeout=IN_TIME) as run:
                job.says.put_nowait(3)
                async for feedback in run.feedback:
                    assert list(feedback.sequence) == [3]
                    break
                job.finish()
                assert list((await run.result).sequence) == [7]
                assert run.status is GoalStatus.SUCCEEDED
            assert job.executed == [ID.bytes]
            assert not job.is_cancelled.is_set()

    play(scenario)


@pytest.mark.also_on_dds
def test_an_attached_run_cancels_only_if_it_is_asked_to(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            async with first.send(goal_id=ID.bytes, keep=True, timeout=IN_TIME):
                await job.began.wait()
            async with second.attach(ID, timeout=IN_TIME):
                pass
            async with first.attach(ID, timeout=IN_TIME) as run:
                assert not job.is_cancelled.is_set()
                assert await run.cancel(timeout=IN_TIME)
                with pytest.raises(GoalCanceled):
                    await run.result
            assert job.is_cancelled.is_set()
            assert len(job.executed) == 1

    play(scenario)


def test_an_attached_run_knows_the_status_that_was_published_before(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, _, job), goalwire.Node('third') as third:
            early, late = third.action(Fibonacci, 'job'), third.action(Fibonacci, 'job')
            await early.wait_for_server(timeout=IN_TIME)
            async with first.send(goal_id=ID, keep=True, timeout=IN_TIME):
                await job.began.wait()
            async with early.attach(ID, timeout=IN_TIME) as run:
                job.says.put_nowait(1)
                await anext(run.feedback)  # the status was published before it
                await turns()
            async with late.attach(ID, timeout=IN_TIME) as run:
                assert run.status is GoalStatus.EXECUTING
                job.finish()
                await run.result

    play(scenario)


@pytest.mark.also_on_dds
def test_attaching_to_a_goal_that_has_ended_gives_its_result(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            job.finish()
            assert list((await first.call(order=4, timeout=IN_TIME)).sequence) == [4]
            (goal_id,) = job.executed
            async with second.attach(goal_id, timeout=IN_TIME) as run:
                assert [feedback async for feedback in run.feedback] == []
                assert list((await run.result).sequence) == [4]

    play(scenario)


@pytest.mark.also_on_dds
def test_attaching_to_an_unknown_goal_sends_none(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, _, job):
            async with first.attach(ID, timeout=IN_TIME) as run:
                with pytest.raises(ServerLostError, match='does not know the goal'):
                    await run.result
            assert job.executed == []
            assert first.statistics().goals.sent == 0
            async with first.send(goal_id=ID, timeout=IN_TIME) as sent:  # it never arrived: this is its first
                job.finish()
                await sent.result

    play(scenario)


@pytest.mark.also_on_dds
def test_cancelling_the_program_keeps_a_kept_goal(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):

            async def drive() -> None:
                async with first.send(order=1, goal_id=ID, keep=True) as run:
                    await run.result

            driving = asyncio.create_task(drive())
            await job.began.wait()
            driving.cancel()
            with pytest.raises(asyncio.CancelledError):
                await driving
            async with second.attach(ID, timeout=IN_TIME) as run:
                job.finish()
                assert list((await run.result).sequence) == [1]

    play(scenario)


@pytest.mark.also_on_dds
@pytest.mark.parametrize('ends_by', ['deadline', 'cancel', 'close'])
def test_a_kept_goal_is_kept_if_its_acceptance_comes_late(play: Play, ends_by: str) -> None:
    async def scenario() -> None:
        asked, decided = asyncio.Event(), asyncio.Event()

        async def hesitate(_: Fibonacci.Goal) -> bool:
            asked.set()
            await decided.wait()
            return True

        job = Job()
        async with goalwire.Node('server') as server, goalwire.Node('watcher') as watcher:
            server.action_server(Fibonacci, 'job', job, accept=hesitate)
            async with goalwire.Node('sender') as sender:
                client = sender.action(Fibonacci, 'job')
                await client.wait_for_server(timeout=IN_TIME)
                timeout = 0.2 if ends_by == 'deadline' else None
                run = client.send(order=2, goal_id=ID, keep=True, timeout=timeout)
                sending = asyncio.ensure_future(run.__aenter__())
                await asked.wait()
                if ends_by == 'cancel':
                    sending.cancel()
                elif ends_by == 'close':
                    client.close()
                with pytest.raises((DeadlineError, asyncio.CancelledError, InvalidHandle)):
                    await sending
                decided.set()
                await job.began.wait()
            async with watcher.action(Fibonacci, 'job').attach(ID, timeout=IN_TIME) as attached:
                job.finish()
                assert list((await attached.result).sequence) == [2]
            assert not job.is_cancelled.is_set()
            assert len(job.executed) == 1

    play(scenario)


def test_a_kept_goal_that_waits_for_a_server_is_not_sent_after_its_block(play: Play) -> None:
    async def scenario() -> None:
        job = Job()
        async with goalwire.Node('sender') as sender, goalwire.Node('server') as server:
            client = sender.action(Fibonacci, 'job')
            sending = asyncio.ensure_future(client.send(keep=True, goal_id=ID).__aenter__())
            await asyncio.sleep(0)
            sending.cancel()
            with pytest.raises(asyncio.CancelledError):
                await sending
            server.action_server(Fibonacci, 'job', job)
            await client.wait_for_server(timeout=IN_TIME)
            job.finish()
            await client.call(timeout=IN_TIME)  # what was sent before would have come before
            assert len(job.executed) == 1
            assert job.executed != [ID.bytes]

    play(scenario)


def test_a_kept_goal_of_a_silent_server_is_not_cancelled(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            async with first.send(goal_id=ID, keep=True, heartbeat=0.05) as run:
                with pytest.raises(ServerStuckError):
                    await run.result
            async with second.attach(ID, timeout=IN_TIME) as attached:
                job.finish()
                await attached.result
            assert not job.is_cancelled.is_set()

    play(scenario)


@pytest.mark.also_on_dds
def test_an_id_that_was_seen_is_never_sent_again(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            async with first.send(goal_id=ID, keep=True, timeout=IN_TIME) as run:
                with pytest.raises(GoalIdTaken, match='was sent before: follow it with attach'):
                    await first.send(goal_id=ID).__aenter__()
                with pytest.raises(GoalIdTaken, match='is followed by this client already'):
                    await first.attach(ID).__aenter__()
                with pytest.raises((GoalIdTaken, GoalRefused)):  # as its status array has come, or not yet
                    await second.send(goal_id=ID, timeout=IN_TIME).__aenter__()
                job.finish()
                await run.result
            with pytest.raises(GoalIdTaken):
                await first.send(goal_id=ID).__aenter__()
            assert job.executed == [ID.bytes]
            assert first.statistics().goals.sent == 1

    play(scenario)


def test_ids_that_are_none_are_refused_before_anything_is_sent(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, job):
            for take in (client.attach, lambda given: client.send(goal_id=given)):
                with pytest.raises(ValueError, match='a goal id has 16 bytes, got 3'):
                    take(b'abc')
                with pytest.raises(ValueError, match='stand for all goals'):
                    take(bytes(16))
                with pytest.raises(TypeError, match=r'16 bytes or a uuid\.UUID, not str'):
                    take('6ba7b810')  # type: ignore[arg-type]
            with pytest.raises(ValueError, match='stand for all goals'):
                await client.probe(bytes(16))
            with pytest.raises(TypeError):
                await client.probe(ID, timeout='soon')  # type: ignore[arg-type]
            assert job.executed == []

    play(scenario)


# -- probing -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.also_on_dds
def test_probing_tells_a_goal_that_runs_one_that_has_ended_and_an_unknown_one(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (first, second, job):
            async with first.send(order=3, goal_id=ID, keep=True, timeout=IN_TIME):
                await job.began.wait()
            running, unknown = await asyncio.gather(second.probe(ID), second.probe(OTHER))
            assert (running.state, running.result) == (goalwire.GoalState.RUNNING, None)
            assert (unknown.state, unknown.status) == (goalwire.GoalState.UNKNOWN, GoalStatus.UNKNOWN)
            assert 'never arrived, was refused, or has ended and was forgotten' in unknown.why
            async with second.attach(ID, timeout=IN_TIME) as run:
                job.finish()
                await run.result
                assert (await second.probe(ID)).state is goalwire.GoalState.ENDED  # while it is followed, too
            ended = await first.probe(ID)
            assert (ended.state, ended.status) == (goalwire.GoalState.ENDED, GoalStatus.SUCCEEDED)
            assert ended.result is not None
            assert list(ended.result.sequence) == [3]
            assert job.executed == [ID.bytes]
            assert second.statistics().goals.sent == 0

    play(scenario)


@pytest.mark.also_on_dds
def test_probing_cannot_tell_without_a_server_or_with_two(play: Play) -> None:
    async def scenario() -> None:
        async with goalwire.Node('asker') as asker, goalwire.Node('server') as server:
            client = asker.action(Fibonacci, 'job')
            alone = await client.probe(ID, timeout=0.1)
            assert alone.state is goalwire.GoalState.CANNOT_TELL
            assert 'no server came' in alone.why
            server.action_server(Fibonacci, 'job', Job())
            async with goalwire.Node('twin') as twin:
                twin.action_server(Fibonacci, 'job', Job())
                await client.wait_for_server(timeout=IN_TIME)
                while len(asker.graph.servers('/job/_action/send_goal')) < 2:
                    await anext(asker.graph.changes())
                both = await client.probe(ID)
                assert both.state is goalwire.GoalState.CANNOT_TELL
                assert both.why.startswith('2 servers have this name')

    play(scenario)


def test_probing_has_a_deadline(play: Play) -> None:
    async def scenario() -> None:
        async with arena() as (client, _, _):
            hurried = await client.probe(ID, timeout=0.3)
            assert hurried.state is goalwire.GoalState.CANNOT_TELL
            assert 'within 0.3 s' in hurried.why

    play(scenario)


@pytest.mark.slow
@pytest.mark.also_on_dds
def test_probing_tells_the_end_of_a_goal_whose_result_is_gone(play: Play) -> None:
    def succeed(goal: Handled) -> Fibonacci.Result:
        goal.succeed()
        return Fibonacci.Result()

    async def scenario() -> None:
        async with goalwire.Node('asker') as asker:
            client = asker.action(Fibonacci, 'job')
            async with client.send(goal_id=ID, keep=True, timeout=IN_TIME) as run:
                with suppress(ServerLostError):  # it is gone at once, mostly before this asks
                    await run.result
            gone = await client.probe(ID)
            assert (gone.state, gone.status) == (goalwire.GoalState.RESULT_GONE, GoalStatus.SUCCEEDED)
            assert gone.result is None

    with Context() as context:
        node = Node('server', context=context)
        with ActionServer(node, Fibonacci, 'job', succeed, result_timeout=0):
            executor = MultiThreadedExecutor(2, context=context)
            executor.add_node(node)
            with Spinner(executor):
                play(scenario)
            executor.shutdown()
        node.destroy_node()


@pytest.mark.also_on_dds
def test_an_attached_run_ends_with_its_server_and_its_goal_is_not_sent_to_the_next(play: Play) -> None:
    async def scenario() -> None:
        lost, next_ = Job(), Job()
        async with goalwire.Node('asker') as asker:
            client = asker.action(Fibonacci, 'job')
            async with goalwire.Node('server') as server:
                server.action_server(Fibonacci, 'job', lost)
                async with client.send(goal_id=ID, keep=True, timeout=IN_TIME):
                    await lost.began.wait()
                run = client.attach(ID, timeout=IN_TIME)
                await run.__aenter__()
            with pytest.raises(GoalAborted):  # a server that closes tells its clients
                await run.result
            await run.__aexit__(None, None, None)
            async with goalwire.Node('server') as server:
                server.action_server(Fibonacci, 'job', next_)
                async with client.attach(ID, timeout=IN_TIME) as again:
                    with pytest.raises(ServerLostError, match='does not know the goal'):
                        await again.result
            assert (len(lost.executed), next_.executed) == (1, [])

    play(scenario)
