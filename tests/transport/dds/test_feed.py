"""Who wants to know of one endpoint."""

from __future__ import annotations

from goalwire.records import replace
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName
from goalwire.transport.dds.feed import Feed
from goalwire.transport.dds.world import UNKNOWN_ID

OWNER = NodeName('arm', '/robot')
ENTITY = GraphEntity(EndpointKind.CLIENT, 'session', 1, OWNER, '/add', gid=b'here')


def test_who_waits_for_an_endpoint_is_told_its_node_once_it_is_shown() -> None:
    feed, told = Feed(), list[NodeName]()
    feed.when_shown(b'here', told.append)
    feed.when_shown(b'never', told.append)
    assert told == []
    feed.change([(True, ENTITY)])
    feed.change([(False, ENTITY), (True, ENTITY)])
    assert told == [OWNER]


def test_an_endpoint_whose_node_is_not_known_is_waited_for() -> None:
    feed, told = Feed(), list[NodeName]()
    nobodys = replace(ENTITY, node_id=UNKNOWN_ID, node=NodeName('?'))
    feed.change([(True, nobodys)])
    feed.when_shown(b'here', told.append)
    feed.change([(False, nobodys), (True, ENTITY)])
    assert told == [OWNER]


def test_the_node_of_an_endpoint_that_is_there_is_told_at_once() -> None:
    feed, told = Feed(), list[NodeName]()
    feed.change([(True, ENTITY)])
    feed.when_shown(b'here', told.append)
    assert told == [OWNER]
