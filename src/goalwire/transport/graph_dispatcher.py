"""Reports the graph's changes to a listener, one at a time and in order."""

from __future__ import annotations

from typing import TypeAlias

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.fault_reports import report_failure
from goalwire.transport.contract import GraphEntity, GraphListener

Change: TypeAlias = tuple[bool, GraphEntity]
"""A node or endpoint, with True if it has come or False if it has gone."""
GraphDispatcher: TypeAlias = OrderedDispatcher[Change | None]
"""Reports changes in the graph to a listener; None means that an endpoint was matched or unmatched."""


def graph_dispatcher(listener: GraphListener) -> GraphDispatcher:
    """Return a dispatcher that reports changes to `listener`.

    The listener's errors are logged, and do not stop later changes.
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
