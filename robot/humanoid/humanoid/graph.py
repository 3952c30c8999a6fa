"""Finds the nodes at the other end of a service or a topic."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rclpy.node import Node


def client_nodes(node: Node, service: str) -> list[str]:
    """Return the nodes that have a client of a service. ROS 2 does not tell which client sent a request."""
    wanted = node.resolve_service_name(service)
    found = []
    for name, namespace in node.get_node_names_and_namespaces():
        try:
            clients = node.get_client_names_and_types_by_node(name, namespace)
        except RuntimeError:  # the node has ended in the meantime
            continue
        if any(each == wanted for each, _ in clients):
            found.append(full_name(name, namespace))
    return sorted(set(found))


def has_service(node: Node, name: str, namespace: str, service: str) -> bool:
    """Return True if the node of that name is a server of the service."""
    wanted = node.resolve_service_name(service)
    try:
        services = node.get_service_names_and_types_by_node(name, namespace)
    except (RuntimeError, ValueError):  # the node has ended, or its name is not yet in the graph
        return False
    return any(each == wanted for each, _ in services)


def publisher_gid(info: Mapping[str, object]) -> bytes | None:
    """Return the gid of a message's publisher, from the message info of the callback.

    rclpy provides the gid since ROS 2 Lyrical; with an older rclpy the result is None.
    """
    told = info.get('publisher_gid')
    gid = told.get('data') if isinstance(told, Mapping) else None
    return gid if isinstance(gid, bytes) else None


def publisher_nodes(node: Node, topic: str, gid: bytes | None = None) -> list[str]:
    """Return the node whose publisher on the topic has that gid; without a match, all publishing nodes."""
    infos = node.get_publishers_info_by_topic(topic)
    those = [info for info in infos if bytes(info.endpoint_gid) == gid] or infos
    return sorted({full_name(info.node_name, info.node_namespace) for info in those})


def subscriber_nodes(node: Node, topic: str) -> list[str]:
    """Return the nodes that subscribe to a topic."""
    infos = node.get_subscriptions_info_by_topic(topic)
    return sorted({full_name(info.node_name, info.node_namespace) for info in infos})


def full_name(name: str, namespace: str) -> str:
    return f'{namespace.rstrip("/")}/{name}'


def one_of(nodes: Sequence[str]) -> str:
    """Return a phrase for an unknown one of `nodes`: "one of /a, /b"; the name if there is only one."""
    if not nodes:
        return 'an unknown node'
    return nodes[0] if len(nodes) == 1 else f'one of {", ".join(nodes)}'
