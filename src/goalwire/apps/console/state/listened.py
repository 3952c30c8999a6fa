"""Topics that other nodes listen to: what a console can tell a robot."""

from __future__ import annotations

from collections.abc import Collection

import goalwire
from goalwire.aio.graph import EndpointKind


def listened_topics(node: goalwire.Node, types: Collection[str]) -> dict[str, str]:
    """Return the topics of these types that other nodes subscribe to, each with its type."""
    return {
        each.name: each.type_name
        for each in node.graph.endpoints()
        if each.kind is EndpointKind.SUBSCRIPTION
        and each.type_name in types
        and each.node.qualified != node.name
    }
