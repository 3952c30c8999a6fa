"""A goal of half a minute: in milliseconds, in the same order each time, on each front and executor."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

import pytest
import rclpy
from example_interfaces.action import Fibonacci
from helpers.robot import ROOT
from rclpy.action import ActionClient, ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import Executor, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node

import goalwire
from goalwire.testing import Graph, VirtualClock

STEPS = 300
STEP_S = 0.1

Trace = list[tuple[float, int]]
"""Virtual time, and the feedback or, last of all, the status that was seen then."""


class Server(Node):
    """A goal takes STEPS steps; its callback sleeps, or is a coroutine that does."""

    def __init__(self, *, coroutine: bool) -> None:
        super().__init__('server')
        execute = self._execute_async if coroutine else self._execute
        self._server = ActionServer(self, Fibonacci, 'count', execute)

    def _execute(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        for step in range(STEPS):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[step]))
            time.sleep(STEP_S)
        goal.succeed()
        return Fibonacci.Result()

    async def _execute_async(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        for step in range(STEPS):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[step]))
            await asyncio.sleep(STEP_S)
        goal.succeed()
        return Fibonacci.Result()


def _in_rclpy(clock: VirtualClock, executor: Callable[[], Executor], *, coroutine: bool) -> Trace:
    trace: Trace = []
    with Graph() as graph:
        graph.start(lambda: Server(coroutine=coroutine), executor=executor)
        node = rclpy.create_node('client')
        client = ActionClient(node, Fibonacci, 'count')
        assert client.wait_for_server(timeout_sec=5.0)
        sent = client.send_goal_async(
            Fibonacci.Goal(order=1),
            feedback_callback=lambda message: trace.append((clock.elapsed, message.feedback.sequence[0])),
        )
        rclpy.spin_until_future_complete(node, sent)
        handle = sent.result()
        assert handle is not None
        answer = handle.get_result_async()
        rclpy.spin_until_future_complete(node, answer, timeout_sec=60.0)
        result = answer.result()
        assert result is not None
        trace.append((clock.elapsed, result.status))
        client.destroy()
        node.destroy_node()
    return trace


def _single(clock: VirtualClock) -> Trace:
    return _in_rclpy(clock, SingleThreadedExecutor, coroutine=False)


def _single_coroutine(clock: VirtualClock) -> Trace:
    return _in_rclpy(clock, SingleThreadedExecutor, coroutine=True)


def _multi(clock: VirtualClock) -> Trace:
    return _in_rclpy(clock, MultiThreadedExecutor, coroutine=False)


def _multi_coroutine(clock: VirtualClock) -> Trace:
    return _in_rclpy(clock, MultiThreadedExecutor, coroutine=True)


def _asyncio(clock: VirtualClock) -> Trace:
    trace: Trace = []

    async def count(goal: goalwire.Goal[Fibonacci.Goal, Fibonacci.Feedback]) -> Fibonacci.Result:
        for step in range(STEPS):
            goal.feedback(sequence=[step])
            await asyncio.sleep(STEP_S)
        return Fibonacci.Result()

    async def play(graph: Graph) -> None:
        async with graph.node('server') as server, graph.node('client') as client:
            server.action_server(Fibonacci, 'count', count)
            async with client.action(Fibonacci, 'count').send(order=1, timeout=60.0) as run:
                async for feedback in run.feedback:
                    trace.append((clock.elapsed, feedback.sequence[0]))
                await run.result
                trace.append((clock.elapsed, run.status))

    with Graph() as graph:
        asyncio.run(play(graph))
    return trace


@pytest.mark.parametrize(
    ('form', 'times'),
    [(_single, 50), (_single_coroutine, 10), (_multi, 10), (_multi_coroutine, 10), (_asyncio, 50)],
)
def test_a_goal_of_half_a_minute_takes_milliseconds_and_goes_the_same_way_each_time(
    form: Callable[[VirtualClock], Trace], times: int
) -> None:
    expected = [(round(step * STEP_S, 6), step) for step in range(STEPS)] + [(30.0, 4)]
    took = []
    for _ in range(times):
        began = time.process_time()
        with VirtualClock() as clock:
            trace = form(clock)
        took.append(time.process_time() - began)
        assert trace == expected
    assert min(took) < 0.5  # s; 16 to 42 ms on a quiet machine


def _humanoid(clock: VirtualClock) -> list[tuple[float, float]]:
    """The robot's own server and client: when each feedback came, and what was left to drive."""
    from humanoid.mission.robot import Robot
    from humanoid.navigation.server import NavigationActionServer

    with Graph() as graph:
        graph.start(NavigationActionServer)
        with Robot() as robot, robot.drive(4.0, 0.0, allowed=30.0, timeout=60.0) as run:
            trace = [(clock.elapsed, feedback.distance_remaining) for feedback in run.feedback()]
        assert run.status == 'SUCCEEDED'
        return [*trace, (clock.elapsed, 0.0)]


def test_the_humanoid_drives_the_same_way_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('GOALWIRE_INTERFACE_PATH', str(ROOT / 'robot'))
    traces = set()
    for _ in range(10):
        with VirtualClock() as clock:
            traces.add(tuple(_humanoid(clock)))
    [trace] = traces
    assert len(trace) == pytest.approx(51, abs=2)
    assert trace[-1][0] == pytest.approx(5.0, abs=0.1)
