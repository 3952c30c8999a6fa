"""Service events: what is published of each step of a call, and when."""

from __future__ import annotations

from typing import Any

import pytest
from example_interfaces.srv import AddTwoInts
from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.spinning import MakeNode, Spin, result_of, wait_until
from rclpy.client import Client
from rclpy.clock import Clock, ROSClock
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_system_default
from rclpy.service import Service
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.time import Time
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

SENT, RECEIVED, ANSWERED, DONE = range(4)
OFF, METADATA, CONTENTS = ServiceIntrospectionState
Event: Any = AddTwoInts.Event
TOPIC = '/ns/add/_service_event'


class World:
    """A client, a service, and a listener to their events, in a node each."""

    def __init__(self, client: Node, server: Node, listener: Node) -> None:
        self.nodes = (client, server, listener)
        self.events: Collector[Any] = Collector()
        listener.create_subscription(Event, TOPIC, self.events, 100)
        self.service: Service[Any, Any] = server.create_service(AddTwoInts, 'add', self._add)
        self.client: Client[Any, Any] = client.create_client(AddTwoInts, 'add')
        wait_until(client.context, self.client.service_is_ready)

    @staticmethod
    def _add(request: AddTwoInts.Request, response: AddTwoInts.Response) -> AddTwoInts.Response:
        response.sum = request.a + request.b
        return response

    def introspect(self, state: ServiceIntrospectionState, publishers: int) -> None:
        """Configure both ends and wait until the listener knows so many publishers."""
        for end, node in ((self.client, self.nodes[0]), (self.service, self.nodes[1])):
            end.configure_introspection(node.get_clock(), qos_profile_system_default, state)
        wait_until(self.nodes[2].context, lambda: self.nodes[2].count_publishers(TOPIC) == publishers)

    def call(self, a: int, b: int) -> int:
        total: int = result_of(self.client.call_async(AddTwoInts.Request(a=a, b=b))).sum
        return total

    def steps(self, count: int) -> list[int]:
        return [event.info.event_type for event in self.events.expect(count)]


@pytest.fixture
def world(make_node: MakeNode, spin: Spin) -> World:
    world = World(*(make_node(name, namespace='ns') for name in ('caller', 'server', 'listener')))
    spin(*world.nodes)
    return world


def by_step(events: list[Any]) -> dict[int, Any]:
    return {event.info.event_type: event for event in events}


def test_contents_are_published_with_every_step(world: World) -> None:
    world.introspect(CONTENTS, 2)
    assert world.call(2, 3) == 5
    events = by_step(world.events.expect(4))
    assert sorted(events) == [SENT, RECEIVED, ANSWERED, DONE]
    for step in (SENT, RECEIVED):
        assert events[step].request == [AddTwoInts.Request(a=2, b=3)]
        assert list(events[step].response) == []
    for step in (ANSWERED, DONE):
        assert list(events[step].request) == []
        assert events[step].response == [AddTwoInts.Response(sum=5)]


def test_metadata_are_published_without_contents(world: World) -> None:
    world.introspect(METADATA, 2)
    world.call(2, 3)
    for event in world.events.expect(4):
        assert (list(event.request), list(event.response)) == ([], [])


def test_all_steps_of_a_call_name_its_client_and_number(world: World) -> None:
    world.introspect(METADATA, 2)
    world.call(1, 1)
    world.call(2, 2)
    infos = [event.info for event in world.events.expect(8)]
    assert len({bytes(info.client_gid) for info in infos}) == 1
    assert bytes(infos[0].client_gid) != bytes(16)
    assert sorted(info.sequence_number for info in infos) == [1, 1, 1, 1, 2, 2, 2, 2]


def test_a_client_tells_of_its_request_before_the_response(world: World) -> None:
    world.client.configure_introspection(ROSClock(), qos_profile_system_default, METADATA)
    wait_until(world.nodes[2].context, lambda: world.nodes[2].count_publishers(TOPIC) == 1)
    for number in range(20):
        world.call(number, 0)
    assert world.steps(40) == [SENT, DONE] * 20


def test_a_blocking_call_is_introspected_too(world: World) -> None:
    world.introspect(METADATA, 2)
    assert world.client.call(AddTwoInts.Request(a=1, b=1), timeout_sec=PATIENCE) is not None
    assert sorted(world.steps(4)) == [SENT, RECEIVED, ANSWERED, DONE]


def test_steps_are_stamped_by_the_clock_that_was_given(world: World) -> None:
    class Stopped(Clock):
        def now(self) -> Time:
            return Time(seconds=42, nanoseconds=7)

    world.client.configure_introspection(Stopped(), qos_profile_system_default, METADATA)
    wait_until(world.nodes[2].context, lambda: world.nodes[2].count_publishers(TOPIC) == 1)
    world.call(0, 0)
    assert {(event.info.stamp.sec, event.info.stamp.nanosec) for event in world.events.expect(2)} == {(42, 7)}


def test_off_takes_the_topic_away_and_it_may_come_back(world: World) -> None:
    world.introspect(CONTENTS, 2)
    world.introspect(OFF, 0)
    world.call(1, 1)
    world.introspect(METADATA, 2)
    world.call(2, 2)
    assert {event.info.sequence_number for event in world.events.expect(4)} == {2}


def test_the_publisher_has_the_given_qos_and_is_not_listed_by_the_node(world: World) -> None:
    qos = QoSProfile(
        depth=7, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )
    world.service.configure_introspection(ROSClock(), qos, CONTENTS)
    server = world.nodes[1]
    (info,) = server.get_publishers_info_by_topic(TOPIC)
    assert info.topic_type == 'example_interfaces/srv/AddTwoInts_Event'
    assert (info.qos_profile.depth, info.qos_profile.reliability) == (7, ReliabilityPolicy.BEST_EFFORT)
    assert info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert TOPIC not in [publisher.topic_name for publisher in server.publishers]


def test_the_topic_is_hidden_and_listed_all_the_same(world: World) -> None:
    world.introspect(METADATA, 2)
    assert topic_or_service_is_hidden(TOPIC)
    names = dict(world.nodes[2].get_topic_names_and_types())
    assert names[TOPIC] == ['example_interfaces/srv/AddTwoInts_Event']


def test_the_topic_goes_with_its_client_or_service(world: World) -> None:
    world.introspect(CONTENTS, 2)
    world.nodes[0].destroy_client(world.client)
    world.nodes[1].destroy_service(world.service)
    wait_until(world.nodes[2].context, lambda: world.nodes[2].count_publishers(TOPIC) == 0)


def test_a_destroyed_client_or_service_cannot_be_introspected(world: World) -> None:
    for end in (world.client, world.service):
        end.destroy()
        with pytest.raises(InvalidHandle):
            end.configure_introspection(ROSClock(), qos_profile_system_default, CONTENTS)


def test_a_state_shows_its_name() -> None:
    assert (str(METADATA), repr(METADATA)) == (
        'ServiceIntrospectionState.METADATA',
        '<ServiceIntrospectionState.METADATA: 1>',
    )


def test_what_is_no_state_is_refused(world: World) -> None:
    with pytest.raises(TypeError, match='2 is not a ServiceIntrospectionState'):
        world.client.configure_introspection(ROSClock(), qos_profile_system_default, 2)  # type: ignore[arg-type]
