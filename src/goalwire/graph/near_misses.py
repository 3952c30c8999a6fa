"""Explains why a name has no server: the graph has the name with another type, or a similar name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import did_you_mean
from goalwire.graph.names import SEND_GOAL, is_part_of_action, show_type
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.graph.graph import Graph

_MOST = 3
"""The number of similar names that are shown."""
_LIKENESS = 0.75
"""The least similarity (0 to 1, by difflib) of a name that is suggested."""


def near_misses(graph: Graph, name: str, *, is_action: bool) -> str:
    """Return advice in one sentence about a name without a server; '' if the graph has nothing similar.

    The expected type is the type of this session's own clients with that name.
    """
    ending = SEND_GOAL if is_action else ''
    servers = graph.entities(EndpointKind.SERVICE, name + ending)
    clients = [
        client
        for client in graph.entities(EndpointKind.CLIENT, name + ending)
        if graph.session is None or client.session == graph.session
    ]
    asked = {client.type_name for client in clients}
    for server in servers:
        if asked and server.type_name not in asked:
            return (
                f"node '{server.node.qualified}' serves that name with the type {show_type(server.type_name)}"
                f", node '{clients[0].node.qualified}' asks for {show_type(clients[0].type_name)}"
            )
    if servers:
        return ''
    similar = similar_names(name, _find_served(graph, is_action=is_action))
    if not similar:
        return ''
    told = []
    for each in similar:
        nodes = dict.fromkeys(
            server.node.qualified for server in graph.entities(EndpointKind.SERVICE, each + ending)
        )
        told.append(f"'{each}'{_of_nodes(list(nodes))}")
    return did_you_mean(told)


def _of_nodes(nodes: list[str]) -> str:
    return f' of the node{"s" if len(nodes) > 1 else ""} {" and ".join(map(repr, nodes))}' if nodes else ''


def similar_names(name: str, names: list[str]) -> list[str]:
    """Return the same name in other namespaces, then names with similar spelling."""
    from difflib import get_close_matches

    base = name.rpartition('/')[2]
    elsewhere = [other for other in names if other != name and other.rpartition('/')[2] == base]
    alike = get_close_matches(name, names, _MOST, _LIKENESS)
    return list(dict.fromkeys(elsewhere + alike))[:_MOST]


def _find_served(graph: Graph, *, is_action: bool) -> list[str]:
    names = graph.names(EndpointKind.SERVICE)
    if is_action:
        return sorted(name.removesuffix(SEND_GOAL) for name in names if name.endswith(SEND_GOAL))
    return sorted(name for name in names if not is_part_of_action(name))
