"""Counts the nodes that a launch has started with each full name, to warn of duplicates."""

from __future__ import annotations

from goalwire.launching.model import LaunchContext

_GLOBAL = 'unique_ros_node_names'


def add_node_name(context: LaunchContext, node_name: str) -> None:
    """Count a node with this full name."""
    counts = dict(context.get_globals().get(_GLOBAL, {}))
    counts[node_name] = counts.get(node_name, 0) + 1
    context.extend_globals({_GLOBAL: counts})


def get_node_name_count(context: LaunchContext, node_name: str) -> int:
    """Return how many nodes with this full name the launch has started."""
    return int(context.get_globals().get(_GLOBAL, {}).get(node_name, 0))
