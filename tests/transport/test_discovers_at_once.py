"""What a session promises of its first look at the graph: tools wait for no longer than they must."""

from __future__ import annotations

from threading import Event

import pytest
from helpers.isolation import isolated_env

from goalwire.graph.graph import Graph
from goalwire.transport import registry
from goalwire.transport.contract import GraphEntity, NodeName, SessionOptions

WIRES = {
    ('rmw_zenoh_cpp', 'native'): True,
    ('rmw_zenoh_cpp', 'eclipse'): False,
    ('rmw_cyclonedds_cpp', ''): False,
    ('goalwire_memory', ''): True,
}


@pytest.mark.parametrize('named', WIRES, ids=' '.join)
def test_a_session_says_whether_its_first_look_is_complete(
    named: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {**isolated_env(named[0]), 'GOALWIRE_ZENOH': named[1]}.items():
        monkeypatch.setenv(name, value)
    session = registry.get(named[0]).open(SessionOptions(domain_id=1))
    try:
        assert session.discovers_at_once is WIRES[named]
    finally:
        session.close()


class _Seen(Graph):
    """A graph that tells when it is complete."""

    def __init__(self) -> None:
        super().__init__()
        self.changed = Event()

    def appeared(self, entity: GraphEntity) -> None:
        super().appeared(entity)
        self.changed.set()


def test_on_dds_a_session_has_heard_all_once_nodes_have_been_told(monkeypatch: pytest.MonkeyPatch) -> None:
    env = isolated_env('rmw_cyclonedds_cpp')
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    options = SessionOptions(domain_id=int(env['ROS_DOMAIN_ID']))
    first, second = (registry.get('rmw_cyclonedds_cpp').open(options) for _ in range(2))
    try:
        first.node(NodeName('told'))
        graph = _Seen()
        second.watch_graph(graph)
        while not graph.node_exists('told'):
            assert graph.changed.wait(20)
            graph.changed.clear()
        assert second.has_heard_all()
    finally:
        second.close()
        first.close()
