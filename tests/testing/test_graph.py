"""A graph of the test's own: what starts in it, what it ends, what it complains about."""

from __future__ import annotations

import asyncio
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
