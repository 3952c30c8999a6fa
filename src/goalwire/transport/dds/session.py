"""One context's session on DDS: a participant, closed once, also where the interpreter ends."""

from __future__ import annotations

import atexit
from weakref import WeakSet

from goalwire.transport.contract import GraphListener, NodeName, NodePort, Session, SessionOptions
from goalwire.transport.dds.core import Core
from goalwire.transport.dds.loading import load
from goalwire.transport.dds.node import DdsNode
from goalwire.transport.members import Members
from goalwire.transport.place import Place

_open: WeakSet[DdsSession] = WeakSet()


def open_session(options: SessionOptions) -> DdsSession:
    """Join a domain. Raises TransportError or ForkedError."""
    return DdsSession(Core(load(), options.domain_id, options.enclave))


class DdsSession(Session):
    """An open session and its nodes."""

    enforces_qos = True
    compares_definitions = False
    discovers_at_once = False

    def __init__(self, core: Core) -> None:
        self.id = core.id
        self.vigil = core.vigil
        self._core = core
        self._place = Place(f'session of domain {core.domain_id}', core.guard, self._leave)
        self._nodes = Members(self._place)
        _open.add(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self._place.check()
        return self._nodes.keep(DdsNode(self._core, name, self._nodes.forget))

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything in the domain."""
        self._place.check()
        self._core.feed.watch(listener)

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._core.rejects.counts()

    def silence(self) -> None:
        """Have publishers and clients send nothing more."""
        self._core.guard.silence()

    def close(self) -> None:
        """Undeclare everything and leave the domain."""
        self._place.give_up()

    def _leave(self) -> None:
        self._core.participant.leaving = True
        try:
            self._nodes.close()
        finally:
            self._core.close()


@atexit.register
def _close_all() -> None:
    for session in list(_open):
        session.close()
