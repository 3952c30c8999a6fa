"""A graph of the test's own: what starts in it, what it ends, what it complains about."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
import time
from collections.abc import Callable

import pytest
import rclpy
from example_interfaces.srv import AddTwoInts
from helpers.wires import require
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool

import goalwire
from goalwire.errors import LocalError
from goalwire.testing import Graph, VirtualClock
from goalwire.testing.world import TRANSPORTS


class Adder(Node):
    def __init__(self) -> None:
        super().__init__('adder')
        self.create_service(AddTwoInts, 'add', self._add)
        self.destroyed = False

    def _add(self, request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response

    def destroy_node(self) -> None:
        self.destroyed = True
        super().destroy_node()


def _play(scenario: Callable[[Graph], object]) -> None:
    with Graph() as graph:
        scenario(graph)


# -- nodes and programs


def test_a_node_is_made_spun_and_destroyed(graph: Graph) -> None:
    def play(inner: Graph) -> Adder:
        adder = inner.start(Adder)
        assert inner.call(AddTwoInts, 'add', a=2, b=3).sum == 5
        assert not adder.destroyed
        return adder

    with Graph() as inner:
        adder = play(inner)
    assert adder.destroyed
    assert not rclpy.ok()


def test_a_node_that_is_there_is_spun_with_the_executor_that_is_wanted(graph: Graph) -> None:
    rclpy.init(args=[])
    adder = Adder()
    assert graph.start(adder, executor=MultiThreadedExecutor) is adder
    assert isinstance(adder.executor, MultiThreadedExecutor)
    assert graph.call(AddTwoInts, 'add', AddTwoInts.Request(a=1, b=1)).sum == 2
    rclpy.shutdown()


def test_a_program_runs_with_its_arguments_until_the_end_of_the_block(clock: VirtualClock) -> None:
    ended = []

    def main() -> None:
        rclpy.init()
        try:
            rclpy.spin(rclpy.create_node('worker'))
        except rclpy.executors.ExternalShutdownException:
            ended.append(True)

    before = sys.argv
    with Graph() as graph:
        program = graph.run(main, '--ros-args', '-r', '__node:=renamed', node='renamed')
        running = [program.running]
        assert sys.argv == [program.name, '--ros-args', '-r', '__node:=renamed']
    running.append(program.running)
    assert running == [True, False]
    assert sys.argv is before
    assert ended == [True]


def test_a_program_that_ends_tells_what_it_returned_or_raised(graph: Graph) -> None:
    def leave() -> None:
        time.sleep(1.0)
        raise SystemExit(3)

    def fail() -> None:
        raise ValueError('boom')

    assert graph.run(lambda: 'done').wait() == 'done'
    assert graph.run(leave).wait() == 3
    with pytest.raises(ValueError, match='boom'):
        graph.run(fail).wait()
    slow = graph.run(lambda: time.sleep(20.0))
    with pytest.raises(AssertionError, match='did not end within 10 s'):
        slow.wait(timeout=10.0)
    slow.wait(timeout=20.0)


def test_a_program_of_asyncio_is_cancelled_at_the_end(clock: VirtualClock) -> None:
    cleaned_up = []

    async def main() -> None:
        async with goalwire.Node('worker') as node:
            node.service(SetBool, 'set', lambda _: SetBool.Response(success=True))
            try:
                await asyncio.Event().wait()
            finally:
                cleaned_up.append(True)

    with Graph() as graph:
        graph.run(main, node='worker')
        assert graph.call(SetBool, 'set').success
    assert cleaned_up == [True]


def test_both_fronts_and_nodes_of_the_graph_meet(graph: Graph) -> None:
    async def play() -> int:
        async with graph.node('client') as one, goalwire.Node('other') as other:
            response = await one.client(AddTwoInts, 'add').call(a=20, b=22, timeout=5.0)
            assert sorted(graph.nodes()) == ['/adder', '/client', '/other']
            assert other.context is not one.context
            return int(response.sum)

    graph.start(Adder)
    assert asyncio.run(play()) == 42


def test_a_call_in_a_coroutine_is_refused_with_what_to_do_instead(graph: Graph) -> None:
    async def play() -> None:
        graph.call(AddTwoInts, 'add')

    with pytest.raises(RuntimeError, match=r'use a client of graph\.node'):
        asyncio.run(play())


def test_fakes_of_one_name_get_nodes_of_their_own_names(graph: Graph) -> None:
    graph.service(SetBool, 'a/set')
    graph.service(SetBool, 'b/set')
    graph.record(String, '~/chatter', node='listener')
    assert graph.nodes() == ['/fake_set', '/fake_set_2', '/listener']


def test_a_node_that_does_not_come_is_said_with_those_that_are_there(graph: Graph) -> None:
    graph.service(SetBool, 'set', node='lamp')
    with pytest.raises(AssertionError, match=r"wanted node '/adder' within 5 s, got \['/lamp'\]"):
        graph.wait_for_node('adder')


# -- isolation


def test_two_graphs_do_not_see_each_other(clock: VirtualClock) -> None:
    with Graph() as one:
        one.service(SetBool, 'set')
        with Graph() as other:
            assert other.domain != one.domain
            assert other.nodes() == []
        assert one.nodes() == ['/fake_set']


def test_the_environment_is_that_of_the_graph_and_then_again_as_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', '7')
    monkeypatch.setenv('ZENOH_CONFIG_OVERRIDE', 'mode="client"')
    before = dict(os.environ)
    with Graph('zenoh') as graph:
        assert os.environ['ROS_DOMAIN_ID'] == str(graph.domain) != '7'
        assert 'ZENOH_CONFIG_OVERRIDE' not in os.environ
        assert graph.environment.items() <= os.environ.items()
        assert graph.environment['RMW_IMPLEMENTATION'] == 'rmw_zenoh_cpp'
    assert dict(os.environ) == before


def test_an_unknown_transport_is_refused() -> None:
    with pytest.raises(LocalError, match="'pigeon'; choose memory, zenoh, dds"), Graph('pigeon'):
        pass


@pytest.mark.parametrize('transport', TRANSPORTS)
def test_it_works_on_every_transport(transport: str) -> None:
    require(TRANSPORTS[transport])
    with Graph(transport) as graph:
        service = graph.service(SetBool, 'set', SetBool.Response(success=True))
        chatter = graph.record(String, 'chatter')
        adder = graph.start(Adder)
        assert graph.call(AddTwoInts, 'add', a=2, b=3, timeout=10.0).sum == 5
        publisher = adder.create_publisher(String, 'chatter', 10)
        chatter.wait_for_publisher(timeout=10.0)
        publisher.publish(String(data='hello'))
        assert graph.call(SetBool, 'set', data=True, timeout=10.0).success
        service.assert_called_with(data=True)


# -- what is wrong at the end


def _leave_a_node_open(graph: Graph) -> None:
    async def play() -> None:
        await goalwire.Node('forgotten').__aenter__()

    asyncio.run(play())


def _leave_rclpy_open(graph: Graph) -> None:
    rclpy.init(args=[])


def _raise_in_a_callback(graph: Graph) -> None:
    def make() -> Node:
        node = rclpy.create_node('failing')
        node.create_timer(1.0, fail)
        return node

    def fail() -> None:
        raise ValueError('boom')

    graph.start(make)
    time.sleep(1.5)


def _fail_in_a_program(graph: Graph) -> None:
    def main() -> None:
        raise ValueError('boom')

    graph.run(main)


@pytest.mark.parametrize(
    ('scenario', 'complaint'),
    [
        (_leave_a_node_open, "left open: a context with node '/forgotten'"),
        (_leave_rclpy_open, 'rclpy was initialised and not shut down'),
        (_raise_in_a_callback, r"node '/failing': a callback raised ValueError\('boom'\)"),
        (_fail_in_a_program, r"program '.*main' raised ValueError\('boom'\)"),
    ],
)
def test_what_is_left_behind_or_went_wrong_fails_the_test(
    clock: VirtualClock, scenario: Callable[[Graph], None], complaint: str
) -> None:
    with pytest.raises(AssertionError, match=complaint):
        _play(scenario)
    assert not rclpy.ok()


def test_a_callback_that_does_not_end_is_named(clock: VirtualClock) -> None:
    gate = threading.Event()

    def scenario(graph: Graph) -> None:
        def make() -> Node:
            node = rclpy.create_node('stuck')
            node.create_timer(1.0, gate.wait)
            return node

        graph.start(make)
        time.sleep(1.5)

    with pytest.raises(AssertionError, match="node '/stuck': a callback did not end"):
        _play(scenario)
    gate.set()
    time.sleep(1.0)


def test_an_error_of_the_test_stays_and_gets_the_complaints_as_a_note(clock: VirtualClock) -> None:
    def scenario(graph: Graph) -> None:
        rclpy.init(args=[])
        raise KeyError('mine')

    with pytest.raises(KeyError, match='mine') as caught:
        _play(scenario)
    assert caught.value.__notes__ == ['rclpy was initialised and not shut down']


def test_rclpy_of_outside_is_not_taken_for_the_graphs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'goalwire_memory')
    rclpy.init(args=[], domain_id=3)
    with Graph() as graph, pytest.raises(LocalError, match='initialised outside this graph'):
        graph.start(Adder)
    assert rclpy.ok()
    rclpy.shutdown()


# -- faults


def test_faults_pass_in_virtual_time(graph: Graph, clock: VirtualClock) -> None:
    from goalwire.transport.faults import Delay

    graph.faults.add(Delay(2.0))
    graph.service(SetBool, 'set', SetBool.Response(success=True))
    assert graph.call(SetBool, 'set', timeout=10.0).success
    assert clock.elapsed == pytest.approx(4.0, abs=0.1)


def test_a_partition_hides_a_server_until_it_is_healed(graph: Graph) -> None:
    faults = graph.faults
    graph.service(SetBool, 'set', SetBool.Response(success=True), node='lamp')
    faults.partition('/lamp', lease=0.0)
    with pytest.raises(goalwire.CallError):
        graph.call(SetBool, 'set', timeout=3.0)
    faults.heal()
    assert graph.call(SetBool, 'set', timeout=3.0).success


def test_faults_that_are_asked_for_too_late_are_refused(graph: Graph) -> None:
    graph.service(SetBool, 'set')
    with pytest.raises(LocalError, match='before its first node'):
        _ = graph.faults
