"""One context's session on DDS: a participant, closed once, also where the interpreter ends."""

from __future__ import annotations

from goalwire.transport.contract import GraphListener, NodeName, NodePort, SessionOptions
from goalwire.transport.dds.context import DdsContext
from goalwire.transport.dds.loading import load
from goalwire.transport.dds.node import DdsNode
from goalwire.transport.endpoint import OpenSession, close_at_exit


def open_session(options: SessionOptions) -> DdsSession:
    """Join a domain. Raises TransportError or ForkedError."""
    return DdsSession(DdsContext(load(), options.domain_id, options.enclave))


class DdsSession(OpenSession):
    """An open session and its nodes."""

    enforces_qos = True
    compares_definitions = False

    def __init__(self, context: DdsContext) -> None:
        super().__init__(context.domain_id, context.guard)
        self.id = context.id
        self.wire_poller = context.wire_poller
        self._context = context
        self.state.undo += [context.close, self.nodes.close, context.participant.leave_at_once]
        close_at_exit(self)

    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""
        with self.nodes.opening(f"node '{name.qualified}'", name.logger) as state:
            return self.nodes.keep(DdsNode(self._context, name, state))

    def watch_graph(self, listener: GraphListener) -> None:
        """Tell `listener` of everything in the domain."""
        self.state.check()
        self._context.notifier.watch(listener)

    def statistics(self) -> dict[str, int]:
        """Return how many requests, replies and announcements broke the rules and were ignored."""
        return self._context.rejects.counts()
