"""Telling listeners of the graph: what is there first, then each change, in order, with no lock held."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from threading import Lock

from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener, NodeName
from goalwire.transport.dds.discovery_state import UNKNOWN_ID, Change
from goalwire.transport.ordered_dispatcher import OrderedDispatcher
from goalwire.transport.reports import report_failure


class _Watcher:
    """One listener; None on its way to it stands for a connection made or lost."""

    def __init__(self, listener: GraphListener) -> None:
        self._listener = listener
        self.dispatcher: OrderedDispatcher[Change | None] = OrderedDispatcher(self._tell)

    def _tell(self, change: Change | None) -> None:
        try:
            if change is None:
                self._listener.connected()
            elif change[0]:
                self._listener.appeared(change[1])
            else:
                self._listener.vanished(change[1])
        except Exception as error:
            report_failure('graph listener', error)


class GraphNotifier:
    """What is there, and who wants to know."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._there: dict[tuple[EndpointKind, str, int, bytes], GraphEntity] = {}
        self._watchers: tuple[_Watcher, ...] = ()
        self._awaited: list[tuple[bytes, Callable[[NodeName], None]]] = []

    def watch(self, listener: GraphListener) -> None:
        """Tell a listener of all there is, before this returns, and of every change until `close`."""
        watcher = _Watcher(listener)
        with watcher.dispatcher.first_turn(), self._lock:
            for entity in self._there.values():
                watcher.dispatcher.post((True, entity))
            self._watchers += (watcher,)

    def change(self, changes: Iterable[Change]) -> None:
        """Take note of changes and tell of them."""
        with self._lock:
            for change in changes:
                self._note(change)
            watchers = self._watchers
            shown = list(self._shown()) if self._awaited else ()
        for watcher in watchers:
            watcher.dispatcher.drain()
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
            watcher.dispatcher.post(change)

    def when_shown(self, gid: bytes, tell: Callable[[NodeName], None]) -> None:
        """Call `tell` with the node of an endpoint once that is known, which may be at once, or never."""
        with self._lock:
            self._awaited.append((gid, tell))
            shown = list(self._shown())
        for node, told in shown:
            told(node)

    def _shown(self) -> Iterator[tuple[NodeName, Callable[[NodeName], None]]]:
        """Yield who waits no longer, and for which node."""
        known = (entity for entity in self._there.values() if entity.node_id != UNKNOWN_ID)
        nodes = {entity.gid: entity.node for entity in known}
        for awaited in list(self._awaited):
            gid, tell = awaited
            if gid in nodes:
                self._awaited.remove(awaited)
                yield nodes[gid], tell

    def connected(self) -> None:
        """An endpoint of this session was connected with another, or disconnected."""
        with self._lock:
            watchers = self._watchers
            for watcher in watchers:
                watcher.dispatcher.post(None)
        for watcher in watchers:
            watcher.dispatcher.drain()

    def close(self) -> None:
        """Tell nobody any more."""
        with self._lock:
            self._watchers = ()
