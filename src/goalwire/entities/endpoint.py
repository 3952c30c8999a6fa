"""Describes an entity as an endpoint for the wire, and settles the policies that its QoS left open."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from goalwire.entities.type_support import MessageSupport, ServiceSupport
from goalwire.errors import RCLError
from goalwire.graph.name_conflicts import opposite
from goalwire.places import caller_place
from goalwire.rules import qos_best_available
from goalwire.rules.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, ReliabilityPolicy
from goalwire.transport.contract import Endpoint, EndpointKind

if TYPE_CHECKING:
    from goalwire.graph.graph import Graph
    from goalwire.rules.qos import QoS

_UNKNOWN = (
    ('history', HistoryPolicy.UNKNOWN),
    ('reliability', ReliabilityPolicy.UNKNOWN),
    ('durability', DurabilityPolicy.UNKNOWN),
    ('liveliness', LivelinessPolicy.UNKNOWN),
)


class EndpointPlaces:
    """The lines of the program that made its endpoints, for warnings about them."""

    MOST = 1000
    """How many names are kept: a program may make and drop endpoints of new names for ever."""

    def __init__(self) -> None:
        self._places: dict[tuple[EndpointKind, str], str] = {}

    def note(self, kind: EndpointKind, name: str) -> None:
        """Note the program's present line as the one that makes an endpoint of this full name."""
        if len(self._places) < self.MOST:
            self._places[kind, name] = caller_place()

    def find(self, kind: EndpointKind, name: str) -> str:
        """Return the line that made the newest endpoint of this full name; '' if it is not known."""
        return self._places.get((kind, name), '')


class HasEndpointPlaces(Protocol):
    """A context, as far as it is needed here."""

    endpoint_places: EndpointPlaces


class InGraph(Protocol):
    """A node, as far as it is needed here."""

    @property
    def context(self) -> HasEndpointPlaces:
        """The node's context."""

    @property
    def graph(self) -> Graph:
        """The discovered nodes and endpoints."""


def describe_endpoint(
    node: InGraph,
    kind: EndpointKind,
    name: str,
    support: MessageSupport | ServiceSupport,
    qos: QoS,
    *,
    waits_for_room: bool | None = None,
) -> Endpoint:
    """Return the endpoint of a fully qualified name; raises RCLError for a policy that is UNKNOWN.

    The context keeps the line of the program that makes the endpoint, for warnings.
    """
    node.context.endpoint_places.note(kind, name)
    return Endpoint(
        kind,
        name,
        support.type_name,
        support.type_hash,
        _settle_qos(node, kind, name, qos),
        isinstance(support, MessageSupport) and support.has_buffers,
        waits_for_room=waits_for_room,
        part_hashes=support.part_hashes if isinstance(support, ServiceSupport) else None,
    )


def _settle_qos(node: InGraph, kind: EndpointKind, name: str, qos: QoS) -> QoS:
    for policy, unknown in _UNKNOWN:
        if getattr(qos, policy) is unknown:
            raise RCLError(
                f"Failed to create {kind.value}: the QoS of '{name}' has {policy} UNKNOWN, "
                f'which no endpoint can have: choose a policy'
            )
    if not qos_best_available.is_open(qos):
        return qos
    if kind in {EndpointKind.SERVICE, EndpointKind.CLIENT}:
        return qos_best_available.for_service(qos)
    others = [each.qos for each in node.graph.entities(opposite(kind), name)]
    if kind is EndpointKind.PUBLISHER:
        return qos_best_available.for_publisher(qos, others)
    return qos_best_available.for_subscription(qos, others)
