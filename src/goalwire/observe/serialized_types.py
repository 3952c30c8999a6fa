"""Types for topics whose messages are only counted, for which no definition of the type is needed."""

from __future__ import annotations

from goalwire.entities.type_support import MessageSupport, find_message_support
from goalwire.graph.graph import Graph
from goalwire.transport.contract import EndpointKind


def find_serialized_type(graph: Graph, topic: str, type_name: str) -> MessageSupport:
    """Return the type support for a raw subscription to the type 'pkg/msg/Name', which may be unknown
    here.

    The hash is that of the topic's publishers, or else of its subscriptions: on Zenoh a subscription with
    another hash gets no messages.
    """
    for kind in (EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION):
        for each in graph.entities(kind, topic):
            if each.type_name == type_name and each.type_hash:
                return find_message_support(type_name, each.type_hash)
    return find_message_support(type_name)
