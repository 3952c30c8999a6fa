"""Servers of this very process: whether a call that blocks here could ever be answered by them."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING, Any

from goalwire.errors import WouldDeadlockError
from goalwire.execution.blocking import why_it_cannot_answer
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.execution.inbox import Inbox
    from goalwire.graph.graph import Graph


class LocalServers:
    """By the name of their service: the inboxes from which their callbacks run."""

    def __init__(self) -> None:
        self._lock = Lock()
        self.inboxes: dict[str, list[Inbox[Any]]] = {}

    def add(self, name: str, inbox: Inbox[Any]) -> None:
        """Note a server."""
        with self._lock:
            self.inboxes.setdefault(name, []).append(inbox)

    def remove(self, name: str, inbox: Inbox[Any]) -> None:
        """Forget a server."""
        with self._lock:
            inboxes = self.inboxes.get(name, [])
            inboxes.remove(inbox)
            if not inboxes:
                self.inboxes.pop(name, None)

    def check(self, graph: Graph, name: str) -> None:
        """Raise WouldDeadlockError where all servers of `name` wait for the calling thread."""
        with self._lock:
            inboxes = list(self.inboxes.get(name, ()))
        if not inboxes or graph.count(EndpointKind.SERVICE, name) > len(inboxes):
            return
        reasons = [why_it_cannot_answer(inbox.home, inbox.group) for inbox in inboxes]
        if all(reasons):
            raise WouldDeadlockError(f"a blocking call of '{name}' can never be answered: {reasons[0]}")
