"""Tells a listener of the graph's changes, one at a time and in order."""

from __future__ import annotations

from typing import TypeAlias

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.reports import report_failure
from goalwire.transport.contract import GraphEntity, GraphListener

Change: TypeAlias = tuple[bool, GraphEntity]
"""True for a thing that has come, False for one that has gone; and the thing."""
GraphDispatcher: TypeAlias = OrderedDispatcher[Change | None]
"""Tells a listener of changes in the graph; None stands for a connection made or lost."""


def graph_dispatcher(listener: GraphListener) -> GraphDispatcher:
    """Return a function that tells `listener` of changes.

    Its errors are reported, and the next change comes all the same.
    """

    def tell(change: Change | None) -> None:
        try:
            if change is None:
                listener.connected()
            elif change[0]:
                listener.appeared(change[1])
            else:
                listener.vanished(change[1])
        except Exception as error:
            report_failure('graph listener', error)

    return OrderedDispatcher(tell)
