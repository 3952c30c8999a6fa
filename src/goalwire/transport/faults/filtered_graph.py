"""What a session sees of the graph, parts of which a partition may hide for a while."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import TypeAlias

from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener
from goalwire.transport.failures import report_failure
from goalwire.transport.ordered_dispatcher import OrderedDispatcher

_Key: TypeAlias = tuple[EndpointKind, str, int, bytes]


def _key_of(entity: GraphEntity) -> _Key:
    return entity.kind, entity.session, entity.node_id, entity.gid


class FilteredGraph(GraphListener):
    """Stands between the wire's graph and one who watches it; `is_hidden` judges each entity.

    What the wire and the faults change at the same time reaches the listener in one order.
    """

    def __init__(self, listener: GraphListener, is_hidden: Callable[[GraphEntity], bool]) -> None:
        self._listener = listener
        self._is_hidden = is_hidden
        self._lock = RLock()
        self._entities: dict[_Key, GraphEntity] = {}
        self._hidden: set[_Key] = set()
        self._owners: dict[bytes, str] = {}
        self._dispatcher: OrderedDispatcher[Callable[[], None]] = OrderedDispatcher(self._tell)

    @staticmethod
    def _tell(change: Callable[[], None]) -> None:
        try:
            change()
        except Exception as error:
            report_failure('graph listener', error)

    def owner_of(self, gid: bytes) -> str:
        """Return the qualified name of the node that an endpoint belongs to, '' where it is unknown."""
        return self._owners.get(gid, '')

    def appeared(self, entity: GraphEntity) -> None:
        key = _key_of(entity)
        with self._lock:
            self._entities[key] = entity
            self._owners[entity.gid] = entity.node.qualified
            if self._is_hidden(entity):
                self._hidden.add(key)
            else:
                self._dispatcher.post(lambda: self._listener.appeared(entity))
        self._dispatcher.drain()

    def vanished(self, entity: GraphEntity) -> None:
        key = _key_of(entity)
        with self._lock:
            self._entities.pop(key, None)
            self._owners.pop(entity.gid, None)
            if key in self._hidden:
                self._hidden.discard(key)
            else:
                self._dispatcher.post(lambda: self._listener.vanished(entity))
        self._dispatcher.drain()

    def connected(self) -> None:
        self._dispatcher.post(self._listener.connected)
        self._dispatcher.drain()

    def look_again(self) -> None:
        """Hide and show what a partition or its end has changed."""
        with self._lock:
            for key, entity in self._entities.items():
                is_hidden = self._is_hidden(entity)
                if is_hidden != (key in self._hidden):
                    self._change(key, entity, is_hidden)
        self._dispatcher.drain()

    def _change(self, key: _Key, entity: GraphEntity, is_hidden: bool) -> None:
        if is_hidden:
            self._hidden.add(key)
            self._dispatcher.post(lambda: self._listener.vanished(entity))
        else:
            self._hidden.discard(key)
            self._dispatcher.post(lambda: self._listener.appeared(entity))

    def has_lost_servers(self, name: str) -> bool:
        """Whether the service has servers, and none of them is in sight."""
        if not self._hidden:
            return False
        with self._lock:
            servers = [
                key
                for key, entity in self._entities.items()
                if entity.kind is EndpointKind.SERVICE and entity.name == name
            ]
            return bool(servers) and self._hidden.issuperset(servers)


class Nobody(GraphListener):
    """Watches for the sake of the session alone."""

    def appeared(self, entity: GraphEntity) -> None:
        """Take no notice."""

    def vanished(self, entity: GraphEntity) -> None:
        """Take no notice."""
