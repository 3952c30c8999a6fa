"""Keeps all robots but the wanted ones out of a graph, since some wires show more than was asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener

if TYPE_CHECKING:
    from goalwire.rules.names.robots import RobotView


def within(view: RobotView | None, graph: GraphListener, session: str) -> GraphListener:
    """Return a listener that passes on to `graph` the nodes and endpoints of a view's robots and of
    `session`. Without a view, return `graph` itself.
    """
    return graph if view is None else _Scope(view, graph, session)


class _Scope(GraphListener):
    """Passes on the nodes and endpoints that a view covers."""

    def __init__(self, view: RobotView, graph: GraphListener, session: str) -> None:
        self._view = view
        self._graph = graph
        self._session = session

    def connected(self) -> None:
        self._graph.connected()

    def appeared(self, entity: GraphEntity) -> None:
        if self._is_seen(entity):
            self._graph.appeared(entity)

    def vanished(self, entity: GraphEntity) -> None:
        if self._is_seen(entity):
            self._graph.vanished(entity)

    def _is_seen(self, entity: GraphEntity) -> bool:
        if entity.session == self._session:
            return True
        if self._view.nodes_only and entity.kind is not EndpointKind.NODE:
            return False
        return self._view.covers(entity.node.namespace)
