"""Finds calls that can never be answered: the server is in this process and needs the thread that waits."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING, Any

from goalwire.errors import WouldDeadlockError
from goalwire.execution.current_callback import why_it_cannot_answer
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.execution.event_queue import EventQueue
    from goalwire.graph.graph import Graph


class DeadlockDetector:
    """Knows the event queues of all request servers of a context, by the names of their services."""

    def __init__(self) -> None:
        self._lock = Lock()
        self.event_queues: dict[str, list[EventQueue[Any]]] = {}

    def add(self, name: str, event_queue: EventQueue[Any]) -> None:
        """Remember a server of this process."""
        with self._lock:
            self.event_queues.setdefault(name, []).append(event_queue)

    def remove(self, name: str, event_queue: EventQueue[Any]) -> None:
        """Forget a server."""
        with self._lock:
            event_queues = self.event_queues.get(name, [])
            event_queues.remove(event_queue)
            if not event_queues:
                self.event_queues.pop(name, None)

    def check(self, graph: Graph, name: str) -> None:
        """Raise WouldDeadlockError if no server of `name` can answer while the calling thread blocks."""
        with self._lock:
            event_queues = list(self.event_queues.get(name, ()))
        if not event_queues or graph.count(EndpointKind.SERVICE, name) > len(event_queues):
            return
        reasons = [
            why_it_cannot_answer(event_queue.work_queue, event_queue.group) for event_queue in event_queues
        ]
        if all(reasons):
            raise WouldDeadlockError(f"a blocking call of '{name}' can never be answered: {reasons[0]}")
