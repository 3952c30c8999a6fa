"""Events from a wire that tells them itself, as DDS does."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest
from helpers.collector import Collector

from goalwire.entities.node import NodeCore
from goalwire.entities.qos_events import EndpointEvents
from goalwire.execution.ready_queue import NodeWorkQueue, ReadyQueue
from goalwire.execution.time.timer_heap import TimerHeap
from goalwire.graph.graph import Graph
from goalwire.rules.qos import DEFAULT, QoS, ReliabilityPolicy
from goalwire.rules.qos_events import (
    EventStatus,
    EventType,
    IncompatibleQoS,
    Matched,
    OfferedDeadlineMissed,
    PublisherEvent,
)
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName, Port

MISSED = PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED
MATCHED = PublisherEvent.RCL_PUBLISHER_MATCHED
INCOMPATIBLE = PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS
STRING = 'std_msgs/msg/String'


class TellingPort(Port):
    """A port that tells one event, missed deadlines."""

    gid = bytes(16)

    def __init__(self) -> None:
        self.told: EventType = MISSED
        self.watched: list[EventType] = []
        self.tell: Callable[[EventStatus], None]

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        if event is not self.told:
            return False
        self.watched.append(event)
        self.tell = changed
        return True

    def close(self) -> None:
        """Nothing to undeclare."""


class World:
    """One publisher's events on a wire where QoS decides who matches."""

    def __init__(self, *, enforces_qos: bool = True, type_hash: str = '') -> None:
        self.port = TellingPort()
        self.graph = Graph()
        self.work_queue = NodeWorkQueue()
        session = SimpleNamespace(enforces_qos=enforces_qos, compares_definitions=True)
        context = SimpleNamespace(session=session)
        remains = SimpleNamespace(add=lambda _: None, discard=lambda _: None)
        node = SimpleNamespace(work_queue=self.work_queue, graph=self.graph, context=context, remains=remains)
        endpoint = Endpoint(EndpointKind.PUBLISHER, '/chat', STRING, type_hash, DEFAULT)
        self.events = EndpointEvents(cast('NodeCore', node), endpoint, self.port)

    def listen(self, event: EventType) -> Collector[Any]:
        came: Collector[Any] = Collector()
        self.events.reader(event, None, came)
        return came

    def run_ready(self) -> None:
        queue = ReadyQueue()
        self.work_queue.attach(queue, TimerHeap(lambda: None))
        while (work := queue.pop()) is not None:
            work.run()
        self.work_queue.detach()


@pytest.fixture
def world() -> World:
    return World()


def subscription(name: bytes, qos: QoS = DEFAULT) -> GraphEntity:
    return GraphEntity(
        EndpointKind.SUBSCRIPTION, 'other', 0, NodeName('other'), '/chat', STRING, '', qos, gid=name
    )


def test_a_wire_that_knows_an_event_is_asked_once_and_tells_every_reader(world: World) -> None:
    first, second = world.listen(MISSED), world.listen(MISSED)
    assert world.port.watched == [MISSED]
    world.port.tell(OfferedDeadlineMissed(total_count=2))
    world.run_ready()
    assert first.items == second.items == [OfferedDeadlineMissed(2, 2)]
    world.port.tell(OfferedDeadlineMissed(total_count=3))
    world.port.tell(OfferedDeadlineMissed(total_count=5))
    world.run_ready()
    assert first.items[1:] == second.items[1:] == [OfferedDeadlineMissed(5, 3)]


def test_what_the_wire_tells_is_not_counted_from_the_graph_as_well(world: World) -> None:
    world.port.told = MATCHED
    matched = world.listen(MATCHED)
    world.listen(INCOMPATIBLE)
    world.graph.appeared(subscription(b'a'))
    world.port.tell(Matched(total_count=1, current_count=1))
    world.run_ready()
    assert matched.items == [Matched(1, 1, 1, 1)]
    assert world.events.status(MATCHED) == Matched(1, current_count=1)


def test_a_peer_that_does_not_tell_its_hash_is_met_by_its_types_name() -> None:
    world = World(type_hash='RIHS01_00')
    matched = world.listen(MATCHED)
    world.graph.appeared(subscription(b'a'))
    world.run_ready()
    assert matched.items == [Matched(1, 1, 1, 1)]


def test_where_qos_prevents_messages_it_prevents_the_match(world: World) -> None:
    matched, incompatible = world.listen(MATCHED), world.listen(INCOMPATIBLE)
    world.graph.appeared(subscription(b'fits'))
    world.graph.appeared(subscription(b'picky', QoS(deadline_ns=1)))
    world.run_ready()
    assert matched.items == [Matched(1, 1, 1, 1)]
    assert [(info.total_count, info.last_policy_kind.name) for info in incompatible.items] == [
        (1, 'RMW_QOS_POLICY_DEADLINE')
    ]
    world.graph.vanished(subscription(b'picky'))
    world.run_ready()
    assert len(matched.items) == 1


def test_where_it_does_not_the_wire_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'goalwire_memory')
    assert World(enforces_qos=False).events.wire_that_delivers_all_the_same == 'goalwire_memory'
    assert World().events.wire_that_delivers_all_the_same is None


def test_nobody_is_told_after_the_end(world: World) -> None:
    matched = world.listen(MATCHED)
    world.graph.appeared(subscription(b'early'))
    world.events.close()
    world.graph.appeared(subscription(b'late'))
    world.run_ready()
    assert matched.items == []
    assert world.events.status(MATCHED) == Matched(1, current_count=1)


def test_events_of_a_kind_are_counted_from_its_first_reader_on_whoever_came_before(world: World) -> None:
    world.graph.appeared(subscription(b'a', QoS(reliability=ReliabilityPolicy.BEST_EFFORT)))
    world.graph.appeared(subscription(b'b', QoS(lease_ns=1)))
    incompatible = world.listen(INCOMPATIBLE)
    matched = world.listen(MATCHED)
    world.run_ready()
    assert matched.items == [Matched(1, 1, 1, 1)]
    assert [type(info) for info in incompatible.items] == [IncompatibleQoS]
