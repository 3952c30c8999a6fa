"""Callers that want to know the node of one endpoint."""

from __future__ import annotations

from goalwire.records import replace
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName
from goalwire.transport.dds.discovery_state import UNKNOWN_ID
from goalwire.transport.dds.notifier import GraphNotifier

OWNER = NodeName('arm', '/robot')
ENTITY = GraphEntity(EndpointKind.CLIENT, 'session', 1, OWNER, '/add', gid=b'here')


def test_who_waits_for_an_endpoint_is_told_its_node_once_it_is_shown() -> None:
    notifier, told = GraphNotifier(), list[NodeName]()
    notifier.when_shown(b'here', told.append)
    notifier.when_shown(b'never', told.append)
    assert told == []
    notifier.change([(True, ENTITY)])
    notifier.change([(False, ENTITY), (True, ENTITY)])
    assert told == [OWNER]


def test_an_endpoint_whose_node_is_not_known_is_waited_for() -> None:
    notifier, told = GraphNotifier(), list[NodeName]()
    nobodys = replace(ENTITY, node_id=UNKNOWN_ID, node=NodeName('?'))
    notifier.change([(True, nobodys)])
    notifier.when_shown(b'here', told.append)
    notifier.change([(False, nobodys), (True, ENTITY)])
    assert told == [OWNER]


def test_the_node_of_an_endpoint_that_is_there_is_told_at_once() -> None:
    notifier, told = GraphNotifier(), list[NodeName]()
    notifier.change([(True, ENTITY)])
    notifier.when_shown(b'here', told.append)
    assert told == [OWNER]
