"""The time that goals of a lost client have for somebody to take them over."""

from __future__ import annotations

from collections.abc import Callable
from heapq import heappop, heappush
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.actions.endpoints import LostClients
from goalwire.execution.clock import ClockTimerEntry
from goalwire.execution.weak_methods import weakly

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore


class ClientGrace:
    """Calls `over(client)` a while after a client went, by the node's clock, on an executor's thread.

    It also watches those who ask for results: whoever attached to a goal may go, too.
    """

    def __init__(
        self,
        node: NodeCore,
        get_result: str,
        grace_ns: int,
        gone: Callable[[bytes], object],
        over: Callable[[bytes], object],
    ) -> None:
        """`gone(client)` is called, on the graph's thread, when one who asked for results goes."""
        self._grace_ns = grace_ns
        self._over = weakly(over)
        self._now = node.clock.now_ns
        self._lock = Lock()
        self._due: list[tuple[int, bytes]] = []
        """When each client's time is over: a heap."""
        self._alarm = ClockTimerEntry(node.work_queue, node.clock, weakly(self._ring))
        self._alarm.follow()
        self.followers = LostClients(node.graph, get_result, gone)
        """Those who asked for results and have gone."""

    def begin(self, client: bytes) -> None:
        """Let the time of a client begin."""
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
            self._over(client)
        if first is not None:
            self._alarm.set(first)

    def close(self) -> None:
        """Stop watching and waiting. Idempotent."""
        self._alarm.cancel()
        self.followers.close()
