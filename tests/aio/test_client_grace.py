"""Goals of clients that have gone have a grace: somebody who asks for their results takes them over."""

from __future__ import annotations

import asyncio
from uuid import UUID

import pytest
from example_interfaces.action import Fibonacci

import goalwire
from goalwire.missions import Runner, Steps, mission
from goalwire.testing import Graph, VirtualClock

ID = UUID('6ba7b810-9dad-41d1-80b4-00c04fd430c8')
GRACE = 30.0


class Job:
    """A handler that takes 100 s, and says when it was cancelled."""

    def __init__(self) -> None:
        self.began = asyncio.Event()
        self.executed = 0
        self.cancelled_after = 0.0

    async def __call__(self, goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        begun = asyncio.get_running_loop().time()
        self.executed += 1
        self.began.set()
        try:
            await asyncio.sleep(100.0)
        except asyncio.CancelledError:
            self.cancelled_after = asyncio.get_running_loop().time() - begun
            raise
        return Fibonacci.Result(sequence=[goal.request.order])


async def send_and_leave(graph: Graph, job: Job) -> None:
    """Send a goal, and end the node 10 s later."""
    async with graph.node('sender') as sender:
        async with sender.action(Fibonacci, 'job').send(order=7, goal_id=ID, keep=True):
            await job.began.wait()
        await asyncio.sleep(10.0)


@pytest.mark.parametrize('how', ['cancel', 'abort'])
def test_without_another_client_the_goal_ends_after_the_grace(
    gw_clock: VirtualClock, gw_graph: Graph, how: str
) -> None:
    async def scenario() -> None:
        job = Job()
        async with gw_graph.node('robot') as robot:
            robot.action_server(Fibonacci, 'job', job, on_client_lost=how, client_grace=GRACE)  # type: ignore[arg-type]
            await send_and_leave(gw_graph, job)
            await asyncio.sleep(200.0)
        assert 40.0 <= job.cancelled_after < 41.0

    asyncio.run(scenario())


def test_whoever_attaches_owns_the_goal_and_leaves_it_to_the_next(
    gw_clock: VirtualClock, gw_graph: Graph
) -> None:
    async def scenario() -> None:
        job = Job()
        async with gw_graph.node('robot') as robot:
            robot.action_server(Fibonacci, 'job', job, on_client_lost='cancel', client_grace=GRACE)
            await send_and_leave(gw_graph, job)
            for _ in range(2):  # a life that ends before the goal does, and one that stays
                async with (
                    gw_graph.node('follower') as follower,
                    follower.action(Fibonacci, 'job').attach(ID) as run,
                ):
                    await asyncio.sleep(35.0)
                    assert job.cancelled_after == 0.0
                    found = run
                await asyncio.sleep(2.0)
            assert found.goal_id == ID.bytes
            await asyncio.sleep(GRACE)
        assert job.cancelled_after == 0.0
        assert job.executed == 1

    asyncio.run(scenario())


def test_the_last_owner_that_goes_begins_the_grace_anew(gw_clock: VirtualClock, gw_graph: Graph) -> None:
    async def scenario() -> None:
        job = Job()
        async with gw_graph.node('robot') as robot:
            robot.action_server(Fibonacci, 'job', job, on_client_lost='cancel', client_grace=GRACE)
            await send_and_leave(gw_graph, job)
            async with gw_graph.node('follower') as follower, follower.action(Fibonacci, 'job').attach(ID):
                await asyncio.sleep(35.0)
            await asyncio.sleep(200.0)
        assert 75.0 <= job.cancelled_after < 76.0  # 10 s, 35 s, and the grace

    asyncio.run(scenario())


def test_a_mission_whose_runner_is_started_again_keeps_its_goal(
    gw_clock: VirtualClock, gw_graph: Graph, tmp_path: object
) -> None:
    @mission()
    async def trip(m: Steps) -> int:
        return (await m.action(Fibonacci, 'job').call(order=7)).sequence[0]

    async def scenario() -> None:
        job = Job()
        async with gw_graph.node('robot') as robot:
            robot.action_server(Fibonacci, 'job', job, on_client_lost='cancel', client_grace=GRACE)
            async with gw_graph.node('runner') as node, Runner(node, f'{tmp_path}/m.db') as runner:
                await runner.start(trip, id='m')
                await job.began.wait()
            await asyncio.sleep(20.0)
            async with gw_graph.node('runner') as node, Runner(node, f'{tmp_path}/m.db') as runner:
                assert await (await runner.start(trip, id='m')).wait() == 7
        assert job.executed == 1

    asyncio.run(scenario())


def test_a_grace_is_a_number_of_seconds(gw_clock: VirtualClock, gw_graph: Graph) -> None:
    async def scenario() -> None:
        async with gw_graph.node('robot') as robot:
            with pytest.raises(TypeError, match='client_grace is a number of seconds'):
                robot.action_server(Fibonacci, 'job', Job(), client_grace='long')  # type: ignore[arg-type]

    asyncio.run(scenario())
