"""The means by which programs of rclpy wait, in virtual time."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterator

import pytest
import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock as ClockMsg
from std_srvs.srv import Trigger

from goalwire.testing import DeadlockError, Graph, VirtualClock


@pytest.fixture
def node(graph: Graph) -> Iterator[Node]:
    rclpy.init(args=[])
    with rclpy.create_node('node') as node:
        yield node
    rclpy.shutdown()


def _spin(node: Node, seconds: float) -> None:
    rclpy.spin_until_future_complete(node, rclpy.Future(), timeout_sec=seconds)


def test_timers_tick_at_their_times_also_where_several_are_due_at_once(
    clock: VirtualClock, node: Node
) -> None:
    ticks: list[tuple[str, float]] = []
    for name, period in (('slow', 3.0), ('fast', 1.5), ('other', 1.5)):
        node.create_timer(period, lambda name=name: ticks.append((name, clock.elapsed)))
    _spin(node, 3.5)
    assert ticks == [
        ('fast', 1.5),
        ('other', 1.5),
        ('slow', 3.0),
        ('fast', 3.0),
        ('other', 3.0),
    ]


def test_a_context_that_is_older_than_the_clock_has_its_deadlines_in_virtual_time() -> None:
    """`rclpy.ok()` makes the default context, which `rclpy.init()` then opens."""
    assert not rclpy.ok()
    with VirtualClock() as clock, Graph(), rclpy.init(args=[]):
        node = rclpy.create_node('node')
        client = node.create_client(Trigger, 'offered_by_nobody')
        client.call_timeout = 3600.0
        answer = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(node, answer)
        assert isinstance(answer.exception(), TimeoutError)
        assert clock.elapsed == 3600.0


def test_a_rate_and_the_sleeps_of_clocks_take_virtual_time(clock: VirtualClock, node: Node) -> None:
    rate = node.create_rate(0.5)
    for _ in range(3):
        rate.sleep()
    assert clock.elapsed == 6.0
    for kind in (ClockType.STEADY_TIME, ClockType.SYSTEM_TIME, ClockType.ROS_TIME):
        Clock(clock_type=kind).sleep_for(Duration(seconds=100))
    assert clock.elapsed == 306.0
    assert node.get_clock().now().nanoseconds == time.time_ns()


def test_waits_of_rclpy_end_in_time(clock: VirtualClock, node: Node) -> None:
    client = node.create_client(Trigger, 'nobody')
    assert not client.wait_for_service(timeout_sec=20.0)
    rclpy.spin_once(node, timeout_sec=10.0)
    assert clock.elapsed == 30.0


def test_a_loop_of_spins_without_a_wait_comes_to_its_timer(clock: VirtualClock, node: Node) -> None:
    ticks: list[float] = []
    node.create_timer(0.25, lambda: ticks.append(clock.elapsed))
    while not ticks:
        rclpy.spin_once(node, timeout_sec=0)
    assert ticks == [pytest.approx(0.25, abs=0.01)]


def test_callbacks_of_all_kinds_sleep_side_by_side(clock: VirtualClock, graph: Graph) -> None:
    ended: list[tuple[str, float]] = []

    def make() -> Node:
        node = rclpy.create_node('busy')
        group = ReentrantCallbackGroup()

        def block(number: int) -> None:
            timers[number].cancel()
            time.sleep(10.0 + number)
            ended.append((f'plain {number}', clock.elapsed))

        async def sleep() -> None:
            timers[3].cancel()
            await asyncio.sleep(10.5)
            ended.append(('coroutine', clock.elapsed))

        callbacks: list[Callable[[], object]] = [lambda number=number: block(number) for number in range(3)]  # type: ignore[misc]
        timers = [node.create_timer(1.0, each, callback_group=group) for each in [*callbacks, sleep]]
        return node

    graph.start(make, executor=MultiThreadedExecutor)
    time.sleep(20.0)
    assert ended == [('plain 0', 11.0), ('coroutine', 11.5), ('plain 1', 12.0), ('plain 2', 13.0)]


def test_simulated_time_is_set_at_virtual_moments(clock: VirtualClock, graph: Graph) -> None:
    """A simulator at half speed: 5 s of its time are 10 s of ours."""
    ticks: list[tuple[int, float]] = []
    simulator = graph.publisher(ClockMsg, '/clock')

    def make() -> Node:
        node = rclpy.create_node('follower', parameter_overrides=[Parameter('use_sim_time', value=True)])
        node.create_timer(2.5, lambda: ticks.append((node.get_clock().now().nanoseconds, clock.elapsed)))
        return node

    graph.start(make)
    simulator.wait_for_subscriber()
    for step in range(1, 101):
        message = ClockMsg()
        message.clock.sec, message.clock.nanosec = divmod(step * 50_000_000, 1_000_000_000)
        simulator.publish(message)
        time.sleep(0.1)
    assert ticks == [(2_500_000_000, 4.9), (5_000_000_000, 9.9)]


def test_a_spin_that_nothing_can_end_says_so_and_where_its_coroutines_wait(
    clock: VirtualClock, node: Node
) -> None:
    async def wait_for_the_impossible() -> None:
        timer.cancel()
        await asyncio.Event().wait()

    timer = node.create_timer(1.0, wait_for_the_impossible)
    with pytest.raises(
        DeadlockError, match=r"coroutine 'wait_for_the_impossible' waits(.|\n)*in wait_for_the_impossible"
    ):
        rclpy.spin(node)


def test_a_callback_that_waits_for_its_own_executor_is_found_out(clock: VirtualClock, graph: Graph) -> None:
    gate = threading.Event()

    def make() -> Node:
        node = rclpy.create_node('waiter')
        node.create_timer(1.0, gate.wait)
        node.create_timer(2.0, gate.set)
        return node

    graph.start(make)
    with pytest.raises(DeadlockError, match=r"thread 'spin /waiter' waits"):
        gate.wait()
    assert clock.elapsed == 1.0
    gate.set()
