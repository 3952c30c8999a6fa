"""Finds conflicts that no wire reports: nodes or endpoints with the same name that are not compatible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import Enum

from goalwire.graph.names import SEND_GOAL, is_part_of_action, show_type
from goalwire.records import record
from goalwire.transport.contract import EndpointKind, GraphEntity


class Reason(Enum):
    """The kinds of conflicts between two endpoints."""

    DEFINITION = 'definition'
    """The endpoints have the same name and type, but different hashes of the type's definition."""
    TYPE = 'type'
    """The endpoints have the same name, but different types."""
    TWO_SERVERS = 'two servers'
    """Two servers have the same name: each gets every request, and the client takes the first reply."""
    TWO_NODES = 'two nodes'
    """Two nodes have the same name, and so their built-in services have the same names, too."""


@record
class Mismatch:
    """A conflict between two endpoints. `name` is the name of the endpoints, of their action, or of their
    nodes.
    """

    reason: Reason
    name: str
    first: GraphEntity
    second: GraphEntity
    separates: bool = True
    """False if the wire does not compare definitions, so that messages are delivered despite the mismatch."""

    @property
    def key(self) -> tuple[object, ...]:
        """The identity of the mismatch. It stays the same if one of the nodes is restarted."""
        sides = sorted(
            (side.kind.value, side.node.qualified, side.type_hash) for side in (self.first, self.second)
        )
        if self.reason is Reason.TWO_NODES:
            return (self.reason, self.name)
        types = sorted({self.first.type_name, self.second.type_name})
        return (self.reason, self.name, *types, *sides)

    def concerns(self, session: str) -> bool:
        """Return whether one of the two endpoints belongs to that session."""
        return session in {self.first.session, self.second.session}

    def __str__(self) -> str:
        first, second = self.first, self.second
        if self.reason is Reason.TWO_NODES:
            return (
                f"two nodes have the name '{self.name}': requests for their parameters and other services "
                f'reach both and the first answer wins; rename one (-r __node:=another)'
            )
        if self.reason is Reason.TYPE:
            return self._about_types()
        if self.reason is Reason.TWO_SERVERS:
            return (
                f"'{self.name}' is served twice, by node '{first.node.qualified}' and by node "
                f"'{second.node.qualified}': every request reaches both and the first "
                f'answer wins; stop or rename one'
            )
        consequence = (
            'nothing passes between them'
            if self.separates
            else 'this wire compares only names, so messages pass and may be rejected or misread'
        )
        return (
            f"{first.kind.value} in node '{first.node.qualified}' and {second.kind.value} in node "
            f"'{second.node.qualified}' share the name '{self.name}' and the type {first.type_name}, but "
            f'not its definition ({first.type_hash} and {second.type_hash}): {consequence}; '
            f'give both the same version of the interface package'
        )

    def _about_types(self) -> str:
        """Return the text about different types. For topics it begins with ROS 2's own text."""
        sides = ' and '.join(
            f"{side.kind.value} in node '{side.node.qualified}' has the type {show_type(side.type_name)}"
            for side in (self.first, self.second)
        )
        if self.first.kind in {EndpointKind.PUBLISHER, EndpointKind.SUBSCRIPTION}:
            opening = f"Incompatible type on topic '{self.name}', no messages will be sent to it"
        else:
            opening = f"Incompatible types of '{self.name}', no requests pass"
        return f'{opening}: {sides}; give both the same type, or give one of them another name'


_OPPOSITES = {
    EndpointKind.PUBLISHER: EndpointKind.SUBSCRIPTION,
    EndpointKind.SUBSCRIPTION: EndpointKind.PUBLISHER,
    EndpointKind.SERVICE: EndpointKind.CLIENT,
    EndpointKind.CLIENT: EndpointKind.SERVICE,
}


def opposite(kind: EndpointKind) -> EndpointKind:
    """Return the kind of the counterparts of an endpoint of this kind; raises KeyError for nodes."""
    return _OPPOSITES[kind]


def find_mismatches(
    newcomer: GraphEntity,
    counterparts: Iterable[GraphEntity],
    fellows: Iterable[GraphEntity],
    *,
    separates: bool = True,
) -> Iterator[Mismatch]:
    """Compare a new endpoint with others of its name: its `counterparts`, and `fellows` of its own kind.

    `separates` says whether different definitions keep endpoints apart. A missing hash is not a difference.
    """
    for peer in counterparts:
        if peer.type_name != newcomer.type_name and peer.type_name and newcomer.type_name:
            if _is_told(newcomer.name):
                yield Mismatch(Reason.TYPE, newcomer.name.removesuffix(SEND_GOAL), peer, newcomer)
            continue
        hashes = {peer.type_hash, newcomer.type_hash} - {''}
        if len(hashes) > 1:
            yield Mismatch(Reason.DEFINITION, newcomer.name, peer, newcomer, separates)
    if newcomer.kind is EndpointKind.SERVICE and _is_told(newcomer.name):
        for peer in fellows:
            if _are_namesakes(peer, newcomer):
                yield Mismatch(Reason.TWO_NODES, newcomer.node.qualified, peer, newcomer)
            else:
                yield Mismatch(Reason.TWO_SERVERS, newcomer.name.removesuffix(SEND_GOAL), peer, newcomer)


def _is_told(name: str) -> bool:
    """Return whether conflicts of this name are reported: of an action's parts only those of send_goal, so
    that each conflict of an action is reported once.
    """
    return name.endswith(SEND_GOAL) or not is_part_of_action(name)


def _are_namesakes(one: GraphEntity, other: GraphEntity) -> bool:
    """Return whether these endpoints belong to two different nodes with the same name."""
    same_node = (one.session, one.node_id) == (other.session, other.node_id)
    return not same_node and one.node.qualified == other.node.qualified
