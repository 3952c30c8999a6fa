"""Which clients of an action server have gone, as the graph shows it."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.graph.graph import Graph
    from goalwire.transport.contract import GraphEntity

REMEMBERED = 1000
"""How many clients that have gone are known, should a goal of theirs still wait for the executor."""


class LostClients:
    """Calls `lost` with the gid of each client of the service `name` that goes, on the graph's thread."""

    def __init__(self, graph: Graph, name: str, lost: Callable[[bytes], object]) -> None:
        self._lost = lost
        self._lock = Lock()
        self._gone: OrderedDict[bytes, None] = OrderedDict()
        self._watch = graph.watch_counterparts(EndpointKind.SERVICE, name, self._note)

    def _note(self, client: GraphEntity, is_there: bool) -> None:
        with self._lock:
            if is_there:
                self._gone.pop(client.gid, None)  # it was out of reach for a while
                return
            self._gone[client.gid] = None
            if len(self._gone) > REMEMBERED:
                self._gone.popitem(last=False)
        self._lost(client.gid)

    def __contains__(self, client: bytes) -> bool:
        return client in self._gone

    def close(self) -> None:
        """Hear of no more. Idempotent."""
        self._watch.close()
