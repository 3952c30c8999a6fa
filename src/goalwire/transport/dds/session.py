"""One context's session on DDS: a participant, closed once, also where the interpreter ends."""

from __future__ import annotations

import atexit
from threading import Lock
from weakref import WeakSet

from goalwire.transport.contract import GraphListener, NodeName, NodePort, Session, SessionOptions
from goalwire.transport.dds.core import Core
from goalwire.transport.dds.loading import load
from goalwire.transport.dds.node import DdsNode
from goalwire.transport.place import Place

_open: WeakSet[DdsSession] = WeakSet()


def open_session(options: SessionOptions) -> DdsSession:
    """Join a domain. Raises TransportError or ForkedError."""
    return DdsSession(Core(load(), options.domain_id, options.enclave))


class DdsSession(Session):
    """An open session and its nodes."""

    enforces_qos = True
    compares_definitions = False

    def __init__(self, core: Core) -> None:
        self.id = core.id
        self.vigil = core.vigil
        self._core = core
        self._place = Place(f'session of domain {core.domain_id}', core.guard, self._leave)
        self._lock = Lock()
        self._nodes: dict[int, DdsNode] = {}
        _open.add(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self._place.check()
        node = DdsNode(self._core, name, self._forget)
        with self._lock:
            if not self._place.closed:
                self._nodes[node.id] = node
                return node
        node.close()
        self._place.check()
        return node

    def _forget(self, node_id: int) -> None:
        with self._lock:
            self._nodes.pop(node_id, None)

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything in the domain."""
        self._place.check()
        self._core.feed.watch(listener)

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._core.rejects.counts()

    def close(self) -> None:
        """Undeclare everything and leave the domain."""
        self._place.give_up()

    def _leave(self) -> None:
        with self._lock:
            nodes = list(self._nodes.values())
        self._core.participant.leaving = True
        try:
            for node in nodes:
                node.close()
        finally:
            self._core.close()


@atexit.register
def _close_all() -> None:
    for session in list(_open):
        session.close()
