"""A node's queries of the graph: nodes, topics, services and endpoints, with their QoS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.errors import NodeNameNonExistentError, RCLError
from goalwire.rules import names
from goalwire.rules.names import InvalidName
from goalwire.transport.contract import EndpointKind, GraphEntity

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.graph.graph import Graph
    from goalwire.graph.names import NamesAndTypes


class NodeGraph:
    """Mixed into Node. Names are fully qualified; types are 'pkg/msg/Name'."""

    if TYPE_CHECKING:

        @property
        def handle(self) -> NodeCore:
            """The node that does the work: goalwire's own, which both APIs share."""

    def get_node_names(self) -> list[str]:
        """Return the name of every node, without namespaces."""
        return [node.node.name for node in self._ros_graph.nodes()]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return '/namespace/name' of every node."""
        return [node.node.qualified for node in self._ros_graph.nodes()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return name and namespace of every node."""
        return [(node.node.name, node.node.namespace) for node in self._ros_graph.nodes()]

    def get_node_names_and_namespaces_with_enclaves(self) -> list[tuple[str, str, str]]:
        """Return name, namespace and enclave of every node."""
        return [(node.node.name, node.node.namespace, node.node.enclave) for node in self._ros_graph.nodes()]

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:  # noqa: ARG002
        """Return every topic with its types; the wire has ROS names, so there is nothing to demangle."""
        return self._ros_graph.topic_names_and_types()

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return every service with its types."""
        return self._ros_graph.service_names_and_types()

    def get_publisher_names_and_types_by_node(
        self,
        node_name: str,
        node_namespace: str,
        no_demangle: bool = False,  # noqa: ARG002
    ) -> NamesAndTypes:
        """Return the topics that a node publishes, with types; raises NodeNameNonExistentError, RCLError for
        a bad name.
        """
        return self._ros_by_node(EndpointKind.PUBLISHER, node_name, node_namespace)

    def get_subscriber_names_and_types_by_node(
        self,
        node_name: str,
        node_namespace: str,
        no_demangle: bool = False,  # noqa: ARG002
    ) -> NamesAndTypes:
        """Return the topics that a node subscribes to, with types; raises NodeNameNonExistentError, RCLError
        for a bad name.
        """
        return self._ros_by_node(EndpointKind.SUBSCRIPTION, node_name, node_namespace)

    def get_service_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return the services of a node; raises NodeNameNonExistentError, RCLError for a bad name."""
        return self._ros_by_node(EndpointKind.SERVICE, node_name, node_namespace)

    def get_client_names_and_types_by_node(self, node_name: str, node_namespace: str) -> NamesAndTypes:
        """Return the services that a node calls; raises NodeNameNonExistentError, RCLError for a bad name."""
        return self._ros_by_node(EndpointKind.CLIENT, node_name, node_namespace)

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has, this node's included."""
        return self._ros_count(EndpointKind.PUBLISHER, topic_name)

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has, this node's included."""
        return self._ros_count(EndpointKind.SUBSCRIPTION, topic_name)

    def count_clients(self, service_name: str) -> int:
        """Return how many clients a service has, this node's included."""
        return self._ros_count(EndpointKind.CLIENT, service_name)

    def count_services(self, service_name: str) -> int:
        """Return how many servers a service has, this node's included."""
        return self._ros_count(EndpointKind.SERVICE, service_name)

    def wait_for_node(self, fully_qualified_node_name: str, timeout: float) -> bool:
        """Block until the node is there (True) or `timeout` seconds have passed (False).

        Raises TypeError for a timeout that is not a number; 0 and less look once.
        """
        if not isinstance(timeout, int | float):
            raise TypeError(f'wait_for_node: the timeout must be a number of seconds, got {timeout!r}')
        namespace, _, name = fully_qualified_node_name.rpartition('/')
        if not self.handle.context.ok():
            return False
        graph = self.handle.graph
        return wait_for_graph(
            self.handle.context, lambda: graph.node_exists(name, namespace or '/'), max(timeout, 0.0)
        )

    @property
    def _ros_graph(self) -> Graph:
        self.handle.check_open()
        return self.handle.graph

    def _ros_by_node(self, kind: EndpointKind, name: str, namespace: str) -> NamesAndTypes:
        what = {
            EndpointKind.PUBLISHER: 'publisher',
            EndpointKind.SUBSCRIPTION: 'subscriber',
            EndpointKind.SERVICE: 'service',
            EndpointKind.CLIENT: 'client',
        }[kind]
        try:
            names.validate_node_name(name)
            names.validate_namespace(namespace)
        except InvalidName as error:
            raise RCLError(f'failed to get {what} names and types: {error.reason}, result: 2') from None
        graph = self._ros_graph
        if not graph.node_exists(name, namespace):
            raise NodeNameNonExistentError(
                f"cannot get {what} names and types for nonexistent node: '{name}' in namespace '{namespace}'"
            )
        return graph.names_and_types_by_node(kind, name, namespace)

    def _ros_full_name(self, name: str) -> str:
        try:
            return names.qualify_topic_name(name, self.handle.name.name, self.handle.name.namespace)
        except InvalidName as error:
            raise ValueError(f"topic name '{name}' is invalid: {error.reason}") from None

    def _ros_count(self, kind: EndpointKind, name: str) -> int:
        return self._ros_graph.count(kind, self._ros_full_name(name))

    def _ros_endpoints(self, kind: EndpointKind, topic: str, no_mangle: bool = False) -> list[GraphEntity]:
        """Return the publishers or subscriptions of a topic, taken verbatim with `no_mangle`, else resolved.

        Raises ValueError for a bad name.
        """
        full = topic if no_mangle else self._ros_full_name(topic)
        if not no_mangle:
            full = self.handle.remaps.topic(full, self.handle.name.name, self.handle.name.namespace)
        return self._ros_graph.entities(kind, full)
