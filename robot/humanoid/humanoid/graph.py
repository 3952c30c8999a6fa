"""Which nodes are at the other end: of a service that was called, of a topic that was published."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node


def client_nodes(node: Node, service: str) -> Sequence[str]:
    """Return the nodes that have a client of a service. ROS 2 does not tell which of them has called it."""
    wanted = node.resolve_service_name(service)
    found = []
    for name, namespace in node.get_node_names_and_namespaces():
        try:
            clients = node.get_client_names_and_types_by_node(name, namespace)
        except RuntimeError:  # the node has gone in the meantime
            continue
        if any(each == wanted for each, _ in clients):
            found.append(full_name(name, namespace))
    return sorted(set(found))


def publisher_nodes(node: Node, topic: str) -> Sequence[str]:
    """Return the nodes that publish a topic."""
    infos = node.get_publishers_info_by_topic(topic)
    return sorted({full_name(info.node_name, info.node_namespace) for info in infos})


def full_name(name: str, namespace: str) -> str:
    return f'{namespace.rstrip("/")}/{name}'


def one_of(nodes: Sequence[str]) -> str:
    """Return a phrase for a node that is among `nodes`: its name if there is only one."""
    if not nodes:
        return 'an unknown node'
    return nodes[0] if len(nodes) == 1 else f'one of {", ".join(nodes)}'
