"""One context's session on DDS: a participant, closed once, also where the interpreter ends."""

from __future__ import annotations

import atexit
from weakref import WeakSet

from goalwire.transport.children import Children
from goalwire.transport.contract import GraphListener, NodeName, NodePort, Session, SessionOptions
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.loading import load
from goalwire.transport.dds.node import DdsNode
from goalwire.transport.endpoint_state import EndpointState

_open: WeakSet[DdsSession] = WeakSet()


def open_session(options: SessionOptions) -> DdsSession:
    """Join a domain. Raises TransportError or ForkedError."""
    return DdsSession(DdsContext(load(), options.domain_id, options.enclave))


class DdsSession(Session):
    """An open session and its nodes."""

    enforces_qos = True
    compares_definitions = False
    discovers_at_once = False

    def __init__(self, context: DdsContext) -> None:
        self.id = context.id
        self.wire_poller = context.wire_poller
        self._context = context
        self._state = EndpointState(f'session of domain {context.domain_id}', context.guard, self._leave)
        self._nodes = Children(self._state)
        _open.add(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        self._state.check()
        return self._nodes.keep(DdsNode(self._context, name, self._nodes.forget))

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything in the domain."""
        self._state.check()
        self._context.notifier.watch(listener)

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._context.rejects.counts()

    def silence(self) -> None:
        """Have publishers and clients send nothing more."""
        self._context.guard.silence()

    def close(self) -> None:
        """Undeclare everything and leave the domain."""
        self._state.close()

    def _leave(self) -> None:
        self._context.participant.leaving = True
        try:
            self._nodes.close()
        finally:
            self._context.close()


@atexit.register
def _close_all() -> None:
    for session in list(_open):
        session.close()
