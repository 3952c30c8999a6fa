"""The statistics of a node: those of everything that it owns. Imported when they are first asked for."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

from goalwire.rules.statistics import (
    ActionClientStatistics,
    ActionServerStatistics,
    ClientStatistics,
    NodeStatistics,
    PublisherStatistics,
    ServiceStatistics,
    SubscriptionStatistics,
    TimerStatistics,
)

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore

_KINDS = (
    PublisherStatistics,
    SubscriptionStatistics,
    ClientStatistics,
    ServiceStatistics,
    ActionClientStatistics,
    ActionServerStatistics,
    TimerStatistics,
)
"""In the order of NodeStatistics' fields."""


def node_statistics(node: NodeCore) -> NodeStatistics:
    """Ask everything that a node owns and that counts something."""
    found: dict[type, list[Any]] = defaultdict(list)
    for entity in node.owned():
        ask = getattr(entity, 'statistics', None)
        if ask is not None:
            record = ask()
            found[type(record)].append(record)
    return NodeStatistics(node.name.qualified, *(tuple(found[kind]) for kind in _KINDS))
