"""The graph as every transport shows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from helpers.wire import ADD, HASH, STRING, SeenGraph, Side, topic_endpoint
from helpers.wires import DDS

from goalwire.errors import ClosedError
from goalwire.records import replace
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.transport.contract import EndpointKind, NodeName, Port, Request, Sample, Session

NODE, PUBLISHER, SUBSCRIPTION = EndpointKind.NODE, EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION
SERVICE, CLIENT = EndpointKind.SERVICE, EndpointKind.CLIENT

Sides = tuple[Side, Side]


def ignore(_: Sample | Request) -> None:
    """Receive and forget."""


def declare_one_of_each(side: Side) -> dict[EndpointKind, Port]:
    return {
        PUBLISHER: side.publisher('/chatter'),
        SUBSCRIPTION: side.subscription('/listened', ignore),
        SERVICE: side.service('/served', ignore),
        CLIENT: side.client('/called'),
    }


NAMES = {PUBLISHER: '/chatter', SUBSCRIPTION: '/listened', SERVICE: '/served', CLIENT: '/called'}


def test_every_kind_of_endpoint_is_shown_to_the_others_with_all_that_is_known_of_it(
    sides: Sides, transport_name: str
) -> None:
    alpha, beta = sides
    ports = declare_one_of_each(alpha)
    (owner,) = beta.graph.expect(NODE, '/alpha')
    for kind, port in ports.items():
        (entity,) = beta.graph.expect(kind, NAMES[kind])
        assert entity.node == NodeName('alpha')
        assert (entity.session, entity.node_id) == (owner.session, owner.node_id)
        assert entity.type_name == (STRING if kind in {PUBLISHER, SUBSCRIPTION} else ADD)
        told = transport_name != DDS or kind in {PUBLISHER, SUBSCRIPTION}
        assert entity.type_hash == (HASH if told else '')  # DDS tells the hashes of a service's halves
        assert entity.gid == port.gid


def test_a_session_knows_its_own_endpoints_by_its_id(session_pair: tuple[Session, Session]) -> None:
    ours, theirs = session_pair
    side, other = Side(ours, 'alpha'), Side(theirs, 'beta')
    side.publisher('/chatter')
    for graph in (side.graph, other.graph):
        assert [seen.session for seen in graph.expect(PUBLISHER, '/chatter')] == [ours.id]
    assert ours.id != theirs.id


def test_a_session_sees_its_own_part_of_the_graph(sides: Sides) -> None:
    alpha, _ = sides
    ports = declare_one_of_each(alpha)
    alpha.graph.expect(NODE, '/alpha')
    for kind, port in ports.items():
        (entity,) = alpha.graph.expect(kind, NAMES[kind])
        assert entity.gid == port.gid


def test_gids_are_sixteen_bytes_and_all_different(sides: Sides) -> None:
    ports = [port for side in sides for port in declare_one_of_each(side).values()]
    assert {len(port.gid) for port in ports} == {16}
    assert len({port.gid for port in ports}) == len(ports)


def test_a_newcomer_knows_everything_before_watching_returns(
    sides: Sides, open_session: Callable[[], Session]
) -> None:
    ports = declare_one_of_each(sides[0])
    for kind in ports:
        sides[1].graph.expect(kind, NAMES[kind])
    seen = SeenGraph()
    sides[1].session.watch_graph(seen)
    assert len(seen.now(NODE)) == 2
    assert {entity.gid for entity in seen.now() if entity.kind is not NODE} == {
        port.gid for port in ports.values()
    }


@pytest.mark.parametrize('kind', list(NAMES))
def test_an_endpoint_that_closes_leaves_the_graph(sides: Sides, kind: EndpointKind) -> None:
    alpha, beta = sides
    ports = declare_one_of_each(alpha)
    beta.graph.expect(kind, NAMES[kind])
    ports[kind].close()
    beta.graph.expect(kind, NAMES[kind], 0)
    alpha.graph.expect(kind, NAMES[kind], 0)
    beta.graph.expect(NODE, '/alpha')


def test_a_node_that_closes_leaves_with_all_its_endpoints(sides: Sides) -> None:
    alpha, beta = sides
    declare_one_of_each(alpha)
    for kind, name in NAMES.items():
        beta.graph.expect(kind, name)
    alpha.node.close()
    beta.graph.expect(NODE, '/alpha', 0)
    for kind, name in NAMES.items():
        beta.graph.expect(kind, name, 0)


def test_a_session_that_closes_leaves_with_all_its_nodes(sides: Sides) -> None:
    alpha, beta = sides
    declare_one_of_each(alpha)
    alpha.session.node(NodeName('second'))
    beta.graph.expect(NODE, '/second')
    alpha.session.close()
    for kind, name in {NODE: '/alpha', **NAMES}.items():
        beta.graph.expect(kind, name, 0)
    beta.graph.expect(NODE, '/second', 0)


@pytest.mark.parametrize(
    'qos',
    [
        QoS(depth=10, liveliness=LivelinessPolicy.AUTOMATIC),
        QoS(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT, liveliness=LivelinessPolicy.AUTOMATIC),
        QoS(
            depth=7,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            history=HistoryPolicy.KEEP_ALL,
            deadline_ns=1_500_000_000,
            lifespan_ns=2_000_000_001,
            liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
            lease_ns=3_000_000_000,
        ),
    ],
)
def test_the_graph_shows_the_qos_asked_for(sides: Sides, transport_name: str, qos: QoS) -> None:
    alpha, beta = sides
    alpha.publisher('/chatter', qos)
    (entity,) = beta.graph.expect(PUBLISHER, '/chatter')
    has_depth = transport_name != DDS or not qos.keeps_all
    assert entity.qos.depth == (qos.depth if has_depth else 0)
    for policy in ('history', 'reliability', 'durability', 'liveliness'):
        assert getattr(entity.qos, policy) == getattr(qos, policy)
    for duration in ('deadline_ns', 'lifespan_ns', 'lease_ns'):
        if asked := getattr(qos, duration):
            assert getattr(entity.qos, duration) == asked


@pytest.mark.parametrize(
    'name',
    [
        NodeName('n'),
        NodeName('walker', '/robot1'),
        NodeName('walker', '/fleet/robot_1/left_leg', '/enclave/of/its/own'),
        NodeName('_hidden_7'),
        NodeName('x' * 200, '/' + '/'.join(['deep'] * 20)),
    ],
)
def test_a_node_is_shown_under_its_full_name(sides: Sides, transport_name: str, name: NodeName) -> None:
    alpha, beta = sides
    alpha.session.node(name)
    (entity,) = beta.graph.expect(NODE, name.qualified)
    enclave = '/' if transport_name == DDS else name.enclave  # there a session has one
    assert entity.node == replace(name, enclave=enclave)


@pytest.mark.parametrize(
    'name',
    ['/a', '/a/b/c/d/e', '/_hidden/topic', '/a__b', '/A1/b2_', '/move/_action/status', '/' + 'long' * 50],
)
def test_a_topic_of_any_allowed_name_is_shown_and_carries_messages(sides: Sides, name: str) -> None:
    alpha, beta = sides
    samples: list[Sample] = []
    alpha.subscription(name, samples.append)
    alpha.publisher(name).publish(b'hello')
    assert [bytes(sample.payload) for sample in samples] == [b'hello']
    for kind in (PUBLISHER, SUBSCRIPTION):
        (entity,) = beta.graph.expect(kind, name)
        assert entity.name == name


def test_two_nodes_of_one_name_are_told_apart(sides: Sides) -> None:
    alpha, beta = sides
    second = alpha.session.node(NodeName('alpha'))
    beta.session.node(NodeName('alpha'))
    twins = beta.graph.expect(NODE, '/alpha', 3)
    assert len({(twin.session, twin.node_id) for twin in twins}) == 3
    second.close()
    beta.graph.expect(NODE, '/alpha', 2)


def test_an_endpoint_belongs_to_the_one_of_two_twins_that_declared_it(sides: Sides) -> None:
    alpha, beta = sides
    twin = alpha.session.node(NodeName('alpha'))
    twin.publisher(topic_endpoint(PUBLISHER, '/chatter'))
    twins = {entity.node_id: entity for entity in beta.graph.expect(NODE, '/alpha', 2)}
    (publisher,) = beta.graph.expect(PUBLISHER, '/chatter')
    assert publisher.node_id in twins
    twin.close()
    (left,) = beta.graph.expect(NODE, '/alpha', 1)
    assert left.node_id != publisher.node_id


def test_several_listeners_may_watch_one_session(sides: Sides) -> None:
    alpha, beta = sides
    second = SeenGraph()
    beta.session.watch_graph(second)
    alpha.publisher('/chatter')
    beta.graph.expect(PUBLISHER, '/chatter')
    second.expect(PUBLISHER, '/chatter')


@pytest.mark.parametrize('kind', list(EndpointKind)[1:], ids=lambda kind: kind.value)
def test_an_endpoint_whose_node_is_closed_while_it_is_declared_is_seen_by_nobody(
    sides: Sides, monkeypatch: pytest.MonkeyPatch, kind: EndpointKind
) -> None:
    """The node is closed at the last moment: when the endpoint is on the wire, and not yet the node's."""
    alpha, beta = sides
    node: Any = getattr(alpha.node, 'inner', alpha.node)
    ports = node.ports
    keep = ports.keep

    def close_and_keep(port: Port) -> Port:
        alpha.node.close()
        kept: Port = keep(port)
        return kept

    monkeypatch.setattr(ports, 'keep', close_and_keep)
    deliver = () if kind in {EndpointKind.PUBLISHER, EndpointKind.CLIENT} else (print,)
    with pytest.raises(ClosedError, match="node '/alpha' was used after"):
        getattr(alpha, kind.value)('/ghost', *deliver)
    for side in sides:
        side.graph.expect(kind, '/ghost', 0)
        side.graph.expect(EndpointKind.NODE, '/alpha', 0)
    assert ports._children == {}
    assert beta.graph.now(EndpointKind.NODE, '/beta')
