"""Reports the graph and its changes to listeners."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from threading import Lock

from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener, NodeName
from goalwire.transport.dds.discovery_state import UNKNOWN_ID
from goalwire.transport.graph_dispatcher import Change, GraphDispatcher, graph_dispatcher


class GraphNotifier:
    """Holds the graph as the listeners know it, and reports its changes to them."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._there: dict[tuple[EndpointKind, str, int, bytes], GraphEntity] = {}
        self._watchers: tuple[GraphDispatcher, ...] = ()
        self._awaited: list[tuple[bytes, Callable[[NodeName], None]]] = []

    def watch(self, listener: GraphListener) -> None:
        """Report the whole graph to a listener before this returns, and every change until `close`."""
        watcher = graph_dispatcher(listener)
        with watcher.first_turn(), self._lock:
            for entity in self._there.values():
                watcher.post((True, entity))
            self._watchers += (watcher,)

    def change(self, changes: Iterable[Change]) -> None:
        """Take over changes and report them to the listeners."""
        with self._lock:
            for change in changes:
                self._note(change)
            watchers = self._watchers
            shown = list(self._find_shown()) if self._awaited else ()
        for watcher in watchers:
            watcher.drain()
        for node, tell in shown:
            tell(node)

    def _note(self, change: Change) -> None:
        is_there, entity = change
        key = entity.kind, entity.session, entity.node_id, entity.gid
        if is_there:
            self._there[key] = entity
        else:
            self._there.pop(key, None)
        for watcher in self._watchers:
            watcher.post(change)

    def when_shown(self, gid: bytes, tell: Callable[[NodeName], None]) -> None:
        """Call `tell` with an endpoint's node once the node is known: perhaps at once, perhaps never."""
        with self._lock:
            self._awaited.append((gid, tell))
            shown = list(self._find_shown())
        for node, told in shown:
            told(node)

    def _find_shown(self) -> Iterator[tuple[NodeName, Callable[[NodeName], None]]]:
        """Yield the node and the function for each awaited endpoint whose node is known now."""
        known = (entity for entity in self._there.values() if entity.node_id != UNKNOWN_ID)
        nodes = {entity.gid: entity.node for entity in known}
        for awaited in list(self._awaited):
            gid, tell = awaited
            if gid in nodes:
                self._awaited.remove(awaited)
                yield nodes[gid], tell

    def connected(self) -> None:
        """Tell the listeners that an endpoint of this session was matched with another, or unmatched."""
        with self._lock:
            watchers = self._watchers
            for watcher in watchers:
                watcher.post(None)
        for watcher in watchers:
            watcher.drain()

    def close(self) -> None:
        """Remove all listeners."""
        with self._lock:
            self._watchers = ()
