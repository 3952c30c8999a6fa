"""The graph, put together from two sources: DDS tells the endpoints, ros_discovery_info tells whose they are.

Pure: it is told what was discovered and returns what that changes. An endpoint is shown once its node is
known. One that no node claims is shown after a while as nobody's, at once where its participant is no ROS 2.
One that goes unclaimed is shown as nobody's and goes: the server of a goal that it sent learns of its end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import NamedTuple, TypeAlias

from goalwire.records import replace
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName
from goalwire.transport.dds.names import Role
from goalwire.transport.dds.participant_info import NodeInfo, ParticipantInfo

Change: TypeAlias = tuple[bool, GraphEntity]
"""Whether it has come, and what."""

UNKNOWN_NAME = '_NODE_NAME_UNKNOWN_'
UNKNOWN_NAMESPACE = '_NODE_NAMESPACE_UNKNOWN_'
UNKNOWN_ID = -1

_KINDS = {
    (Role.TOPIC, False): EndpointKind.PUBLISHER,
    (Role.TOPIC, True): EndpointKind.SUBSCRIPTION,
    (Role.REQUEST, True): EndpointKind.SERVICE,
    (Role.REQUEST, False): EndpointKind.CLIENT,
}


class Found(NamedTuple):
    """An endpoint as discovery shows it."""

    gid: bytes
    participant: bytes
    role: Role
    is_reader: bool
    name: str
    type_name: str
    type_hash: str
    qos: QoS


@dataclass(slots=True)
class _Node:
    """One node of a participant, as last heard of."""

    entity: GraphEntity
    gids: frozenset[bytes]


@dataclass(slots=True)
class _Participant:
    guid: bytes
    enclave: str
    speaks_ros: bool = False
    nodes: list[_Node] = field(default_factory=list)
    owners: dict[bytes, _Node] = field(default_factory=dict)
    shown: dict[bytes, GraphEntity] = field(default_factory=dict)
    found: dict[bytes, Found] = field(default_factory=dict)
    """Every endpoint that there is, shown or not."""
    next_id: Iterator[int] = field(default_factory=count)


class DiscoveryState:
    """What was discovered of the other participants."""

    def __init__(self) -> None:
        self._participants: dict[bytes, _Participant] = {}
        self._homes: dict[bytes, bytes] = {}
        self.unclaimed: set[bytes] = set()
        """The endpoints that wait for a node to claim them."""

    def participant_came(self, guid: bytes, enclave: str) -> None:
        """A participant is there; told before its endpoints."""
        self._participants.setdefault(guid, _Participant(guid, enclave))

    def participant_went(self, guid: bytes) -> list[Change]:
        """A participant has gone, with all it had."""
        participant = self._participants.get(guid)
        if participant is None:
            return []
        changes = self.give_up_on(list(participant.found))
        del self._participants[guid]
        for gid in participant.found:
            self._homes.pop(gid, None)
        gone = [*participant.shown.values(), *(node.entity for node in participant.nodes)]
        return changes + [(False, entity) for entity in gone]

    def ros_speaker_came(self, guid: bytes) -> None:
        """A participant will tell its nodes: its endpoints wait for that."""
        if (participant := self._participants.get(guid)) is not None:
            participant.speaks_ros = True

    def endpoint_came(self, found: Found) -> list[Change]:
        """An endpoint is there."""
        participant = self._participants.get(found.participant)
        if (
            participant is None
            or found.gid in participant.found
            or (found.role, found.is_reader) not in _KINDS
        ):
            return []
        participant.found[found.gid] = found
        self._homes[found.gid] = found.participant
        owner = participant.owners.get(found.gid)
        if owner is None and participant.speaks_ros:
            self.unclaimed.add(found.gid)
            return []
        return [_show(participant, found, owner)]

    def endpoint_went(self, gid: bytes) -> list[Change]:
        """An endpoint has gone."""
        changes = self.give_up_on([gid])
        participant = self._participants.get(self._homes.pop(gid, b''))
        if participant is None:
            return []
        participant.found.pop(gid, None)
        entity = participant.shown.pop(gid, None)
        return changes if entity is None else [*changes, (False, entity)]

    def told(self, info: ParticipantInfo) -> list[Change]:
        """A participant has told its nodes and whose its endpoints are."""
        participant = self._participants.get(info.gid)
        if participant is None:
            return []
        participant.speaks_ros = True
        earlier = participant.nodes
        participant.nodes = list(_identified(participant, info.nodes))
        participant.owners = {gid: node for node in participant.nodes for gid in node.gids}
        kept = {node.entity.node_id for node in participant.nodes}
        changes = list(self._rehomed(participant))
        changes += [(False, node.entity) for node in earlier if node.entity.node_id not in kept]
        known = {node.entity.node_id for node in earlier}
        newcomers: list[Change] = [
            (True, node.entity) for node in participant.nodes if node.entity.node_id not in known
        ]
        return newcomers + changes

    def give_up_on(self, gids: Iterable[bytes]) -> list[Change]:
        """Show those of these endpoints that no node has claimed as nobody's."""
        changes = []
        for gid in gids:
            participant = self._participants.get(self._homes.get(gid, b''))
            if participant is not None and gid in self.unclaimed:
                self.unclaimed.remove(gid)
                changes.append(_show(participant, participant.found[gid], None))
        return changes

    def _rehomed(self, participant: _Participant) -> Iterator[Change]:
        """Move each endpoint to the node that claims it now; hide those that nobody claims any more."""
        for gid, found in participant.found.items():
            owner, shown = participant.owners.get(gid), participant.shown.get(gid)
            work_queue = UNKNOWN_ID if owner is None else owner.entity.node_id
            if shown is not None and shown.node_id != work_queue:
                del participant.shown[gid]
                yield False, shown
                shown = None
            if shown is not None:
                continue
            if owner is None:
                self.unclaimed.add(gid)
            else:
                self.unclaimed.discard(gid)
                yield _show(participant, found, owner)


def _identified(participant: _Participant, told: tuple[NodeInfo, ...]) -> Iterator[_Node]:
    """Recognise the nodes that were there before: by name, and twins by their endpoints."""
    earlier: dict[tuple[str, str], list[_Node]] = {}
    for node in participant.nodes:
        earlier.setdefault((node.entity.node.namespace, node.entity.node.name), []).append(node)
    for info in told:
        gids = frozenset((*info.readers, *info.writers))
        namesakes = earlier.get((info.namespace, info.name), [])
        if not namesakes:
            yield _Node(_node_entity(participant, info), gids)
            continue
        same = namesakes[0] if len(namesakes) == 1 else max(namesakes, key=partial(_likeness, gids))
        namesakes.remove(same)
        yield _Node(same.entity, gids)


def _likeness(gids: frozenset[bytes], node: _Node) -> tuple[bool, int]:
    return node.gids == gids, len(node.gids & gids)


def _node_entity(participant: _Participant, info: NodeInfo) -> GraphEntity:
    name = NodeName(info.name, info.namespace, participant.enclave)
    return GraphEntity(EndpointKind.NODE, participant.guid.hex(), next(participant.next_id), name)


def _show(participant: _Participant, found: Found, owner: _Node | None) -> Change:
    if owner is None:
        nobody = NodeName(UNKNOWN_NAME, UNKNOWN_NAMESPACE, participant.enclave)
        node = GraphEntity(EndpointKind.NODE, participant.guid.hex(), UNKNOWN_ID, nobody)
    else:
        node = owner.entity
    entity = participant.shown[found.gid] = replace(
        node,
        kind=_KINDS[found.role, found.is_reader],
        name=found.name,
        type_name=found.type_name,
        type_hash=found.type_hash,
        qos=found.qos,
        gid=found.gid,
    )
    return True, entity
