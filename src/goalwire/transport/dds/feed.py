"""Telling listeners of the graph: what is there first, then each change, in order, with no lock held."""

from __future__ import annotations

from collections.abc import Iterable
from threading import Lock

from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener, NodeName
from goalwire.transport.dds.world import Change
from goalwire.transport.failures import report_failure
from goalwire.transport.outbox import Outbox


class _Watcher:
    """One listener; None on its way to it stands for a connection made or lost."""

    def __init__(self, listener: GraphListener) -> None:
        self._listener = listener
        self.outbox: Outbox[Change | None] = Outbox(self._tell)

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


class Feed:
    """What is there, and who wants to know."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._there: dict[tuple[EndpointKind, str, int, bytes], GraphEntity] = {}
        self._watchers: tuple[_Watcher, ...] = ()

    def watch(self, listener: GraphListener) -> None:
        """Tell a listener of all there is, before this returns, and of every change until `close`."""
        watcher = _Watcher(listener)
        with watcher.outbox.first_turn(), self._lock:
            for entity in self._there.values():
                watcher.outbox.post((True, entity))
            self._watchers += (watcher,)

    def change(self, changes: Iterable[Change]) -> None:
        """Take note of changes and tell of them."""
        with self._lock:
            for change in changes:
                self._note(change)
            watchers = self._watchers
        for watcher in watchers:
            watcher.outbox.drain()

    def _note(self, change: Change) -> None:
        is_there, entity = change
        key = entity.kind, entity.session, entity.node_id, entity.gid
        if is_there:
            self._there[key] = entity
        else:
            self._there.pop(key, None)
        for watcher in self._watchers:
            watcher.outbox.post(change)

    def owner(self, gid: bytes) -> NodeName | None:
        """Return the node that an endpoint belongs to, None for an unknown one; it searches them all."""
        with self._lock:
            return next((each.node for each in self._there.values() if each.gid == gid), None)

    def connected(self) -> None:
        """An endpoint of this session was connected with another, or disconnected."""
        with self._lock:
            watchers = self._watchers
            for watcher in watchers:
                watcher.outbox.post(None)
        for watcher in watchers:
            watcher.outbox.drain()

    def close(self) -> None:
        """Tell nobody any more."""
        with self._lock:
            self._watchers = ()
