"""Tells an action server of clients that have gone: at once, or after a grace period in which others may take
over their goals.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from functools import partial
from heapq import heappop, heappush
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.execution.event_queue import CallSoon
from goalwire.execution.time.clock import ClockTimerEntry
from goalwire.execution.weak_methods import weakly
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.entities.names import ResolvedAction
    from goalwire.entities.node import NodeCore
    from goalwire.graph.graph import Graph
    from goalwire.transport.contract import GraphEntity

REMEMBERED = 1000
"""How many of the clients that have gone are remembered, for goals of theirs that wait for the executor."""


class ClientWatch:
    """Calls the action server back when a client goes, on an executor's thread. Does not keep the server
    alive.
    """

    def __init__(
        self,
        node: NodeCore,
        names: ResolvedAction,
        grace_ns: int,
        gone: Callable[[bytes], object],
        lost: Callable[[bytes], object],
    ) -> None:
        """`lost(client)` is called when a client has gone, and has not come back within the grace.

        If there is a grace (on the node's clock), `gone(client)` is called first, when the client goes. Then
        clients that only ask for results are watched, too: they have attached to goals.
        """
        self._work_queue = node.work_queue
        self._grace_ns = grace_ns
        self._gone, self._lost = weakly(gone), weakly(lost)
        self._now = node.clock.now_ns
        self._lock = Lock()
        self._due: list[tuple[int, bytes]] = []
        """A heap of the times at which the clients' graces end."""
        self._alarm = ClockTimerEntry(node.work_queue, node.clock, weakly(self._ring))
        self._alarm.follow()
        served = (names.send_goal, names.get_result) if grace_ns else (names.send_goal,)
        self._watches = [LostClients(node.graph, name, self._note) for name in served]

    def has_lost(self, client: bytes) -> bool:
        """Return whether a client that sends a goal has gone, and its goals have no grace."""
        return not self._grace_ns and client in self._watches[0]

    def _note(self, client: bytes) -> None:
        """Note that a client has gone. Runs on the graph's thread."""
        self._later(self._begin if self._grace_ns else self._lost, client)

    def _begin(self, client: bytes) -> None:
        """Begin the grace period of a lost client: its goals end if nobody attaches to them in time."""
        self._gone(client)
        with self._lock:
            heappush(self._due, (self._now() + self._grace_ns, client))
            first = self._due[0][0]
        self._alarm.set(first)

    def _ring(self) -> None:
        over: list[bytes] = []
        with self._lock:
            while self._due and self._due[0][0] <= self._now():
                over.append(heappop(self._due)[1])
            first = self._due[0][0] if self._due else None
        for client in over:
            if any(client in watch for watch in self._watches):  # otherwise the client came back
                self._later(self._lost, client)
        if first is not None:
            self._alarm.set(first)

    def _later(self, call: Callable[[bytes], object], client: bytes) -> None:
        self._work_queue.post(CallSoon(self._work_queue, partial(call, client)))

    def close(self) -> None:
        """Stop watching and waiting. Idempotent."""
        self._alarm.cancel()
        for watch in self._watches:
            watch.close()


class LostClients:
    """Calls `lost`, on the graph's thread, with the gid of each client of the service `name` that goes."""

    def __init__(self, graph: Graph, name: str, lost: Callable[[bytes], object]) -> None:
        self._lost = weakly(lost)
        self._lock = Lock()
        self._gone: OrderedDict[bytes, None] = OrderedDict()
        self._watch = graph.watch_counterparts(EndpointKind.SERVICE, name, weakly(self._note))

    def _note(self, client: GraphEntity, is_there: bool) -> None:
        with self._lock:
            if is_there:
                self._gone.pop(client.gid, None)  # the client is back: it was only out of reach
                return
            self._gone[client.gid] = None
            if len(self._gone) > REMEMBERED:
                self._gone.popitem(last=False)
        self._lost(client.gid)

    def __contains__(self, client: bytes) -> bool:
        return client in self._gone

    def close(self) -> None:
        """Stop watching. Idempotent."""
        self._watch.close()
