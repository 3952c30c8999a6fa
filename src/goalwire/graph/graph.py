"""Keeps the discovered graph: nodes and endpoints, and the watchers of changes.

It follows the rules of rmw_zenoh's graph cache. A node is identified by its session and number, so two nodes
with the same name are two entries. An endpoint of an unknown node adds that node. If a node is removed, its
endpoints are removed, too. The removal of an unknown node or endpoint is ignored, since the wire guarantees
no order.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import TypeAlias

from goalwire.graph.name_conflicts import Mismatch, find_mismatches, opposite
from goalwire.graph.names import NamesAndTypes, actions_among
from goalwire.graph.watch import CounterpartWatch, CounterpartWatchers, Watch, Watchers
from goalwire.locks import ForkableLock
from goalwire.rules.names.actions import ActionNames
from goalwire.rules.qos_compatibility import incompatible_policy
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, GraphListener

_NodeKey: TypeAlias = tuple[str, int]
_Endpoints: TypeAlias = dict[bytes, GraphEntity]
"""Endpoints by gid, in the order in which they appeared."""


class _Node:
    """One node and its endpoints; `is_declared` is False while only endpoints of the node have been seen."""

    __slots__ = ('endpoints', 'entity', 'is_declared')

    def __init__(self, entity: GraphEntity, *, is_declared: bool = False) -> None:
        self.entity = entity
        self.is_declared = is_declared
        self.endpoints: _Endpoints = {}


class Graph(GraphListener):
    """The discovered graph, which a session's `watch_graph` fills. Any thread may query it."""

    def __init__(
        self, session: str | None = None, *, compares_definitions: bool = True, enforces_qos: bool = False
    ) -> None:
        """Make an empty graph that reports the mismatches of endpoints of `session`; None: all mismatches.

        `compares_definitions` and `enforces_qos` say whether the session's wire connects endpoints with
        different definitions of a type, or with incompatible QoS: it does not if they are True.
        """
        self.session = session
        """The session whose mismatches are reported; None: those of all sessions."""
        self._compares_definitions = compares_definitions
        self._enforces_qos = enforces_qos
        self._lock = ForkableLock()
        self.version = 0
        """A number that rises with each change of the graph. A cache reads the version before its query, and
        keeps both.
        """
        self._nodes: dict[_NodeKey, _Node] = {}
        self._nodes_by_name: dict[tuple[str, str], dict[_NodeKey, _Node]] = defaultdict(dict)
        self._endpoints: dict[EndpointKind, dict[str, _Endpoints]] = {
            kind: defaultdict(dict) for kind in EndpointKind if kind is not EndpointKind.NODE
        }
        self._mismatches: set[tuple[object, ...]] = set()  # keys of the mismatches that were reported
        self._change_watchers: Watchers[[]] = Watchers()
        self._counterparts = CounterpartWatchers()
        self._mismatch_watchers: Watchers[[Mismatch]] = Watchers()

    # -- called by the transport ---------------------------------------------------------------------------

    def appeared(self, entity: GraphEntity) -> None:
        """Add a node or endpoint; does nothing if the graph has it already."""
        found: list[Mismatch] = []
        with self._lock:
            if entity.kind is EndpointKind.NODE:
                changed = self._add_node(entity)
            else:
                changed = self._add_endpoint(entity)
            if changed and entity.kind is not EndpointKind.NODE:
                found = self._new_mismatches(entity)
            self.version += changed
        if changed:
            self._counterparts.tell()
            self._change_watchers.tell()
        for mismatch in found:
            self._mismatch_watchers.tell(mismatch)

    def vanished(self, entity: GraphEntity) -> None:
        """Remove an endpoint, or a node with its endpoints; does nothing if the graph does not have it."""
        with self._lock:
            if entity.kind is EndpointKind.NODE:
                changed = self._remove_node(entity)
            else:
                changed = self._remove_endpoint(entity)
            self.version += changed
        if changed:
            self._counterparts.tell()
            self._change_watchers.tell()

    def connected(self) -> None:
        """Wake the threads and tasks that wait for the graph, so that they look again."""
        with self._lock:
            self.version += 1
        self._change_watchers.tell()

    def on_change(self, callback: Callable[[], object]) -> Watch[[]]:
        """Call `callback` after each change, on the thread of the change, until the returned Watch is closed.

        To wait for a state, first watch, then look at the graph, then sleep until the next call.
        """
        return self._change_watchers.add(callback)

    def on_mismatch(self, callback: Callable[[Mismatch], object]) -> Watch[[Mismatch]]:
        """Call `callback` for each mismatch that is found from now on, but only once if its endpoints go and
        return.
        """
        return self._mismatch_watchers.add(callback)

    def watch_counterparts(
        self, kind: EndpointKind, name: str, callback: Callable[[GraphEntity, bool], object]
    ) -> CounterpartWatch:
        """Call `callback(endpoint, is_there)` for each counterpart of an endpoint of that kind and name.

        First it is called for the existing counterparts, then once for each change, in order, on the thread
        of the change. Types and QoS are not compared.
        """
        with self._lock:
            there = self._endpoints[opposite(kind)].get(name, {})
            watch = self._counterparts.add(opposite(kind), name, callback, there.values())
        self._counterparts.tell()
        return watch

    # -- nodes ---------------------------------------------------------------------------------------------

    def nodes(self) -> list[GraphEntity]:
        """Return all nodes; two nodes with the same name are two entries."""
        with self._lock:
            return [node.entity for node in self._nodes.values()]

    def node_exists(self, name: str, namespace: str = '/') -> bool:
        """Return whether a node of that name is in the graph."""
        with self._lock:
            return (namespace, name) in self._nodes_by_name

    # -- endpoints -----------------------------------------------------------------------------------------

    def entities(self, kind: EndpointKind, name: str) -> list[GraphEntity]:
        """Return the endpoints of one kind and name."""
        with self._lock:
            return list(self._endpoints[kind].get(name, {}).values())

    def endpoints(self) -> list[GraphEntity]:
        """Return every endpoint. Endpoints of one kind and name are in the order in which they appeared."""
        with self._lock:
            return [
                endpoint
                for by_name in self._endpoints.values()
                for endpoints in by_name.values()
                for endpoint in endpoints.values()
            ]

    def count(self, kind: EndpointKind, name: str) -> int:
        """Return the number of endpoints of one kind and name, whatever their types and QoS."""
        with self._lock:
            return len(self._endpoints[kind].get(name, ()))

    def names(self, kind: EndpointKind) -> list[str]:
        """Return the names of the endpoints of one kind."""
        with self._lock:
            return list(self._endpoints[kind])

    def has_service(self, name: str, type_name: str) -> bool:
        """Return whether the graph has a server of that name and type; hash and QoS are not compared."""
        with self._lock:
            for server in self._endpoints[EndpointKind.SERVICE].get(name, {}).values():
                if server.type_name == type_name:
                    return True
        return False

    def find_matched(self, endpoint: Endpoint | GraphEntity) -> list[GraphEntity]:
        """Return an endpoint's counterparts with the same name and type, and with compatible QoS if the wire
        enforces QoS.
        """
        others = self.entities(opposite(endpoint.kind), endpoint.name)
        return [
            other
            for other in others
            if other.type_name == endpoint.type_name and (not self._enforces_qos or _agree(endpoint, other))
        ]

    # -- names and types -----------------------------------------------------------------------------------

    def topic_names_and_types(self) -> NamesAndTypes:
        """Return every topic that has a publisher or a subscription."""
        return self._names_and_types(EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION)

    def service_names_and_types(self) -> NamesAndTypes:
        """Return every service that has a server or a client."""
        return self._names_and_types(EndpointKind.SERVICE, EndpointKind.CLIENT)

    def served_names_and_types(self) -> NamesAndTypes:
        """Return every service that has a server."""
        return self._names_and_types(EndpointKind.SERVICE)

    def action_names_and_types(self) -> NamesAndTypes:
        """Return every action that has a server or a client."""
        return actions_among(self.topic_names_and_types())

    def served_action_names_and_types(self) -> NamesAndTypes:
        """Return every action that has a server, found by the publishers of feedback."""
        return actions_among(self._names_and_types(EndpointKind.PUBLISHER))

    def names_and_types_by_node(self, kind: EndpointKind, name: str, namespace: str = '/') -> NamesAndTypes:
        """Return the names and types of the first such node's endpoints of one kind; empty if there is no
        such node.
        """
        with self._lock:
            nodes = self._nodes_by_name.get((namespace, name), {})
            first = next(iter(nodes.values()), None)
            endpoints = list(first.endpoints.values()) if first else []
        return _sort(endpoint for endpoint in endpoints if endpoint.kind is kind)

    def action_servers_by_node(self, name: str, namespace: str = '/') -> NamesAndTypes:
        """Return the actions that a node serves."""
        return actions_among(self.names_and_types_by_node(EndpointKind.PUBLISHER, name, namespace))

    def action_clients_by_node(self, name: str, namespace: str = '/') -> NamesAndTypes:
        """Return the actions of which a node has a client."""
        return actions_among(self.names_and_types_by_node(EndpointKind.SUBSCRIPTION, name, namespace))

    def has_action(self, name: str, type_name: str) -> bool:
        """Return whether the graph has an action server with all five parts, as rcl_action checks it."""
        parts = ActionNames(name)
        return (
            self.has_service(parts.send_goal, f'{type_name}_SendGoal')
            and self.has_service(parts.cancel_goal, 'action_msgs/srv/CancelGoal')
            and self.has_service(parts.get_result, f'{type_name}_GetResult')
            and self.count(EndpointKind.PUBLISHER, parts.feedback) > 0
            and self.count(EndpointKind.PUBLISHER, parts.status) > 0
        )

    def _names_and_types(self, *kinds: EndpointKind) -> NamesAndTypes:
        with self._lock:
            found = [
                endpoint
                for kind in kinds
                for endpoints in self._endpoints[kind].values()
                for endpoint in endpoints.values()
            ]
        return _sort(found)

    # -- the tables; callers hold the lock -----------------------------------------------------------------

    def _node_of(self, entity: GraphEntity) -> _Node:
        """Return the node that an entity belongs to; add the node if it is unknown."""
        key = entity.session, entity.node_id
        node = self._nodes.get(key)
        if node is None:
            node = self._nodes[key] = _Node(
                GraphEntity(EndpointKind.NODE, entity.session, entity.node_id, entity.node)
            )
            self._nodes_by_name[entity.node.namespace, entity.node.name][key] = node
        return node

    def _add_node(self, entity: GraphEntity) -> bool:
        node = self._node_of(entity)
        changed = not node.is_declared
        node.entity, node.is_declared = entity, True
        return changed

    def _add_endpoint(self, entity: GraphEntity) -> bool:
        endpoints = self._node_of(entity).endpoints
        if entity.gid in endpoints:
            return False
        endpoints[entity.gid] = self._endpoints[entity.kind][entity.name][entity.gid] = entity
        self._counterparts.note(entity, is_there=True)
        return True

    def _remove_node(self, entity: GraphEntity) -> bool:
        node = self._nodes.get((entity.session, entity.node_id))
        if node is None:
            return False
        for endpoint in node.endpoints.values():
            self._discard_endpoint(endpoint)
        self._discard_node(node)
        return True

    def _remove_endpoint(self, entity: GraphEntity) -> bool:
        node = self._nodes.get((entity.session, entity.node_id))
        known = node.endpoints.pop(entity.gid, None) if node else None
        if node is None or known is None:
            return False
        self._discard_endpoint(known)
        if not node.endpoints and not node.is_declared:
            self._discard_node(node)
        return True

    def _discard_endpoint(self, entity: GraphEntity) -> None:
        self._counterparts.note(entity, is_there=False)
        by_name = self._endpoints[entity.kind]
        del by_name[entity.name][entity.gid]
        if not by_name[entity.name]:
            del by_name[entity.name]

    def _discard_node(self, node: _Node) -> None:
        key = node.entity.session, node.entity.node_id
        name = node.entity.node.namespace, node.entity.node.name
        del self._nodes[key]
        del self._nodes_by_name[name][key]
        if not self._nodes_by_name[name]:
            del self._nodes_by_name[name]

    def _new_mismatches(self, entity: GraphEntity) -> list[Mismatch]:
        counterparts = self._endpoints[opposite(entity.kind)].get(entity.name, {})
        fellows = self._endpoints[entity.kind][entity.name]
        found = []
        others = (fellow for gid, fellow in fellows.items() if gid != entity.gid)
        separates = self._compares_definitions
        for mismatch in find_mismatches(entity, counterparts.values(), others, separates=separates):
            ours = self.session is None or mismatch.concerns(self.session)
            if ours and mismatch.key not in self._mismatches:
                self._mismatches.add(mismatch.key)
                found.append(mismatch)
        return found


def _agree(one: Endpoint | GraphEntity, other: GraphEntity) -> bool:
    """Return whether the QoS of two topic endpoints is compatible; True for services."""
    if one.kind is EndpointKind.PUBLISHER:
        return incompatible_policy(one.qos, other.qos) is None
    if one.kind is EndpointKind.SUBSCRIPTION:
        return incompatible_policy(other.qos, one.qos) is None
    return True


def _sort(endpoints: Iterable[GraphEntity]) -> NamesAndTypes:
    types: dict[str, set[str]] = defaultdict(set)
    for endpoint in endpoints:
        types[endpoint.name].add(endpoint.type_name)
    return [(name, sorted(types[name])) for name in sorted(types)]
