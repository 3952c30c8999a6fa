"""An endpoint is told who comes and goes on the other side of its topic."""

from __future__ import annotations

from itertools import count

import pytest

from goalwire.graph.graph import Graph
from goalwire.logging import LogRecord
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName

PUBLISHER, SUBSCRIPTION = EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION
STRING = 'std_msgs/msg/String'

_numbers = count(1)


def endpoint(kind: EndpointKind, name: str, node_id: int = 0) -> GraphEntity:
    gid = next(_numbers).to_bytes(16, 'little')
    return GraphEntity(kind, 'session', node_id, NodeName('node'), name, STRING, gid=gid)


class Log:
    def __init__(self) -> None:
        self.told: list[tuple[GraphEntity, bool]] = []

    def __call__(self, entity: GraphEntity, is_there: bool) -> None:
        self.told.append((entity, is_there))


@pytest.fixture
def graph() -> Graph:
    return Graph()


def test_those_already_there_come_first_and_then_each_change(graph: Graph) -> None:
    early, late = endpoint(SUBSCRIPTION, '/chat'), endpoint(SUBSCRIPTION, '/chat')
    graph.appeared(early)
    log = Log()
    graph.watch_counterparts(PUBLISHER, '/chat', log)
    graph.appeared(late)
    graph.vanished(early)
    assert log.told == [(early, True), (late, True), (early, False)]


def test_other_topics_and_fellows_are_not_told(graph: Graph) -> None:
    log = Log()
    graph.watch_counterparts(PUBLISHER, '/chat', log)
    graph.appeared(endpoint(SUBSCRIPTION, '/other'))
    graph.appeared(endpoint(PUBLISHER, '/chat'))
    assert log.told == []


def test_what_is_seen_twice_is_told_once(graph: Graph) -> None:
    log = Log()
    graph.watch_counterparts(SUBSCRIPTION, '/chat', log)
    publisher = endpoint(PUBLISHER, '/chat')
    graph.appeared(publisher)
    graph.appeared(publisher)
    graph.vanished(publisher)
    graph.vanished(publisher)
    assert log.told == [(publisher, True), (publisher, False)]


def test_a_node_that_goes_takes_its_endpoints_along(graph: Graph) -> None:
    log = Log()
    graph.watch_counterparts(SUBSCRIPTION, '/chat', log)
    publisher = endpoint(PUBLISHER, '/chat', node_id=3)
    graph.appeared(publisher)
    graph.vanished(GraphEntity(EndpointKind.NODE, 'session', 3, NodeName('node')))
    assert log.told == [(publisher, True), (publisher, False)]


def test_a_closed_watch_is_told_no_more_and_the_others_are(graph: Graph) -> None:
    log, other = Log(), Log()
    watch = graph.watch_counterparts(SUBSCRIPTION, '/chat', log)
    graph.watch_counterparts(SUBSCRIPTION, '/chat', other)
    watch.close()
    watch.close()
    graph.appeared(endpoint(PUBLISHER, '/chat'))
    assert (len(log.told), len(other.told)) == (0, 1)


def test_a_callback_may_ask_the_graph_and_bring_about_changes(graph: Graph) -> None:
    counts: list[int] = []

    def ask(_entity: GraphEntity, _is_there: bool) -> None:
        counts.append(graph.count(PUBLISHER, '/chat'))
        if len(counts) == 1:
            graph.appeared(endpoint(PUBLISHER, '/chat'))

    graph.watch_counterparts(SUBSCRIPTION, '/chat', ask)
    graph.appeared(endpoint(PUBLISHER, '/chat'))
    assert counts == [1, 2]


def test_what_a_callback_raises_spares_the_others(graph: Graph, records: list[LogRecord]) -> None:
    def fail(_entity: GraphEntity, _is_there: bool) -> None:
        raise ValueError('mine')

    log = Log()
    graph.watch_counterparts(SUBSCRIPTION, '/chat', fail)
    graph.watch_counterparts(SUBSCRIPTION, '/chat', log)
    graph.appeared(endpoint(PUBLISHER, '/chat'))
    assert len(log.told) == 1
    assert 'mine' in records[-1].message
