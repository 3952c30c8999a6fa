"""rclpy.action.graph: finds the actions in the graph, and the nodes that call or serve actions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.errors import NodeNameNonExistentError
from rclpy._reexports import reexport

if TYPE_CHECKING:
    from goalwire.graph.names import NamesAndTypes
    from rclpy.impl.base_node import BaseNode


def get_action_client_names_and_types_by_node(
    node: BaseNode, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node calls; raises NodeNameNonExistentError."""
    _check_there(node, remote_node_name, remote_node_namespace)
    return node.handle.graph.action_clients_by_node(remote_node_name, remote_node_namespace)


def get_action_server_names_and_types_by_node(
    node: BaseNode, remote_node_name: str, remote_node_namespace: str
) -> NamesAndTypes:
    """Return the actions that a node serves; raises NodeNameNonExistentError."""
    _check_there(node, remote_node_name, remote_node_namespace)
    return node.handle.graph.action_servers_by_node(remote_node_name, remote_node_namespace)


def get_action_names_and_types(node: BaseNode) -> NamesAndTypes:
    """Return every action in the graph with its types."""
    return node.handle.graph.action_names_and_types()


def _check_there(node: BaseNode, name: str, namespace: str) -> None:
    if not node.handle.graph.node_exists(name, namespace):
        raise NodeNameNonExistentError(
            f"cannot get action names and types for nonexistent node: '{name}' in namespace '{namespace}'"
        )


reexport(__name__)
