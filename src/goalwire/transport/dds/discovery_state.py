"""The graph from two sources: DDS announces the endpoints, ros_discovery_info the node that owns each.

Pure: its methods take what was discovered and return what changes in the graph. An endpoint is shown once its
node is known. If no node claims it for a while, it is shown without a node; at once if its participant is not
ROS 2. An endpoint that disappears before a node has claimed it is shown without a node and then removed. So
an action server learns that the client of a goal has gone.

ros_discovery_info is a rmw_dds_common/msg/ParticipantEntitiesInfo: the nodes of a participant, and the
endpoints of each. It is read and written by hand, not by the codec, since the wire has two forms of it: Gids
of 16 bytes, and of 24 up to Humble.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from itertools import count
from struct import Struct
from typing import NamedTuple

from goalwire.errors import RemoteError
from goalwire.records import record, replace
from goalwire.rules.qos import QoS
from goalwire.transport.contract import EndpointKind, GraphEntity, NodeName
from goalwire.transport.dds.description import Role
from goalwire.transport.graph_dispatcher import Change
from goalwire.transport.graph_names import check_names

GID_SIZE = 16
OLD_GID_SIZE = 24
"""The size of a Gid up to Humble: the same 16 bytes and 8 zeros."""
NAME_LIMIT = 256

_ENCAPSULATION = b'\x00\x01\x00\x00'
_U32 = Struct('<I')
_EMPTY_SIZE = len(_ENCAPSULATION) + GID_SIZE + _U32.size


@record
class NodeInfo:
    """One node and the gids of its endpoints."""

    namespace: str
    name: str
    readers: tuple[bytes, ...] = ()
    writers: tuple[bytes, ...] = ()


@record
class ParticipantInfo:
    """The nodes of one participant."""

    gid: bytes
    nodes: tuple[NodeInfo, ...] = ()


def encode_info(info: ParticipantInfo, gid_size: int = GID_SIZE) -> bytes:
    """Return the message with Gids of 16 or 24 bytes."""
    parts = [_ENCAPSULATION, info.gid.ljust(gid_size, b'\0'), _U32.pack(len(info.nodes))]
    for node in info.nodes:
        for text in (node.namespace, node.name):
            raw = text.encode() + b'\0'
            raw = _U32.pack(len(raw)) + raw
            parts.append(raw.ljust(-(-len(raw) // 4) * 4, b'\0'))
        for gids in (node.readers, node.writers):
            parts.append(_U32.pack(len(gids)))
            parts += [gid.ljust(gid_size, b'\0') for gid in gids]
    return b''.join(parts)


def decode_info(payload: bytes) -> ParticipantInfo:
    """Read a message of either form; raises RemoteError for anything else."""
    if payload[:2] != _ENCAPSULATION[:2]:
        raise RemoteError(f'ros_discovery_info: encapsulation {payload[:4].hex()} is not little-endian CDR')
    return _InfoReader(payload, _gid_size(payload)).participant()


def _gid_size(payload: bytes) -> int:
    """Return the size of the message's Gids. Only in the longer form 8 zeros follow the first 16 bytes."""
    tail = payload[len(_ENCAPSULATION) + GID_SIZE :][: OLD_GID_SIZE - GID_SIZE]
    has_room = len(payload) > _EMPTY_SIZE
    return OLD_GID_SIZE if has_room and tail == bytes(OLD_GID_SIZE - GID_SIZE) else GID_SIZE


class _InfoReader:
    """Reads one message from front to back."""

    def __init__(self, payload: bytes, gid_size: int) -> None:
        self._payload = payload
        self._position = len(_ENCAPSULATION)
        self._gid_size = gid_size

    def participant(self) -> ParticipantInfo:
        try:
            gid = self._gid()
            return ParticipantInfo(gid, tuple(self._node() for _ in range(self._count(4))))
        except UnicodeDecodeError as error:
            raise RemoteError(f'ros_discovery_info: at byte {self._position}: {error}') from None

    def _node(self) -> NodeInfo:
        namespace, name = self._text(), self._text()
        return NodeInfo(namespace, name, self._gids(), self._gids())

    def _take(self, size: int) -> bytes:
        taken = self._payload[self._position : self._position + size]
        if len(taken) < size:
            raise RemoteError(
                f'ros_discovery_info: at byte {self._position}: {size} bytes expected, {len(taken)} left'
            )
        self._position += size
        return taken

    def _count(self, least_size: int) -> int:
        """Read a count of items of at least `size` bytes each; raises RemoteError if the rest is shorter."""
        self._position += -self._position % 4
        (count,) = _U32.unpack(self._take(4))
        if count * least_size > len(self._payload):
            raise RemoteError(f'ros_discovery_info: at byte {self._position}: {count} items do not fit')
        return int(count)

    def _text(self) -> str:
        raw = self._take(self._count(1)).removesuffix(b'\0')
        if len(raw) > NAME_LIMIT:
            raise RemoteError(f'ros_discovery_info: a name of {len(raw)} bytes, {NAME_LIMIT} are allowed')
        name = raw.decode()
        check_names('ros_discovery_info', name)
        return name

    def _gids(self) -> tuple[bytes, ...]:
        return tuple(self._gid() for _ in range(self._count(self._gid_size)))

    def _gid(self) -> bytes:
        return self._take(self._gid_size)[:GID_SIZE]


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


class _Node(NamedTuple):
    """One node of a participant, as it was last announced."""

    entity: GraphEntity
    gids: frozenset[bytes]


class _Participant:
    """One participant, its nodes and endpoints."""

    def __init__(self, guid: bytes, enclave: str) -> None:
        self.guid = guid
        self.enclave = enclave
        self.speaks_ros = False
        self.has_told = False
        """True once the participant has announced its nodes."""
        self.nodes: list[_Node] = []
        self.owners: dict[bytes, _Node] = {}
        self.shown: dict[bytes, GraphEntity] = {}
        self.found: dict[bytes, Found] = {}
        """Every endpoint that belongs in the graph, shown already or not."""
        self.seen: set[bytes] = set()
        """Every announced endpoint, including those that the graph does not show."""
        self.next_id = count()


class DiscoveryState:
    """The participants, nodes and endpoints that are known, and the part of them that the graph shows."""

    def __init__(self) -> None:
        self._participants: dict[bytes, _Participant] = {}
        self._participant_of: dict[bytes, bytes] = {}
        self.unclaimed: set[bytes] = set()
        """The endpoints that wait for a node to claim them."""

    def participant_came(self, guid: bytes, enclave: str) -> None:
        """Add a participant; called before its endpoints are added."""
        self._participants.setdefault(guid, _Participant(guid, enclave))

    def participant_went(self, guid: bytes) -> list[Change]:
        """Remove a participant with its nodes and endpoints."""
        participant = self._participants.get(guid)
        if participant is None:
            return []
        changes = self.show_unclaimed(list(participant.found))
        del self._participants[guid]
        for gid in participant.found:
            self._participant_of.pop(gid, None)
        gone = [*participant.shown.values(), *(node.entity for node in participant.nodes)]
        return changes + [(False, entity) for entity in gone]

    def ros_speaker_came(self, guid: bytes) -> None:
        """Note that a participant will announce its nodes: its endpoints are not shown before."""
        if (participant := self._participants.get(guid)) is not None:
            participant.speaks_ros = True

    def endpoint_came(self, found: Found) -> list[Change]:
        """Add an endpoint."""
        participant = self._participants.get(found.participant)
        if participant is not None:
            participant.seen.add(found.gid)
        if (
            participant is None
            or found.gid in participant.found
            or (found.role, found.is_reader) not in _KINDS
        ):
            return []
        participant.found[found.gid] = found
        self._participant_of[found.gid] = found.participant
        owner = participant.owners.get(found.gid)
        if owner is None and participant.speaks_ros:
            self.unclaimed.add(found.gid)
            return []
        return [_show(participant, found, owner)]

    def endpoint_went(self, gid: bytes) -> list[Change]:
        """Remove an endpoint."""
        changes = self.show_unclaimed([gid])
        participant = self._participants.get(self._participant_of.pop(gid, b''))
        if participant is None:  # an endpoint that the graph does not show
            for other in self._participants.values():
                other.seen.discard(gid)
            return []
        participant.found.pop(gid, None)
        participant.seen.discard(gid)
        entity = participant.shown.pop(gid, None)
        return changes if entity is None else [*changes, (False, entity)]

    def learn(self, info: ParticipantInfo) -> list[Change]:
        """Take over a participant's announcement of its nodes and their endpoints."""
        participant = self._participants.get(info.gid)
        if participant is None:
            return []
        participant.speaks_ros = participant.has_told = True
        earlier = participant.nodes
        participant.nodes = list(_identify_nodes(participant, info.nodes))
        participant.owners = {gid: node for node in participant.nodes for gid in node.gids}
        kept = {node.entity.node_id for node in participant.nodes}
        changes = list(self._move(participant))
        changes += [(False, node.entity) for node in earlier if node.entity.node_id not in kept]
        known = {node.entity.node_id for node in earlier}
        newcomers: list[Change] = [
            (True, node.entity) for node in participant.nodes if node.entity.node_id not in known
        ]
        return newcomers + changes

    def is_complete(self) -> bool:
        """Return whether all nodes are known, and all endpoints that they claim. Any thread."""
        for participant in list(self._participants.values()):
            if not participant.seen:
                return False
            if participant.speaks_ros and not participant.owners.keys() <= participant.seen:
                return False
            if participant.speaks_ros and not participant.has_told:
                return False
        return not self.unclaimed

    def show_unclaimed(self, gids: Iterable[bytes]) -> list[Change]:
        """Show the given endpoints without a node, if they still wait for one."""
        changes = []
        for gid in gids:
            participant = self._participants.get(self._participant_of.get(gid, b''))
            if participant is not None and gid in self.unclaimed:
                self.unclaimed.remove(gid)
                changes.append(_show(participant, participant.found[gid], None))
        return changes

    def _move(self, participant: _Participant) -> Iterator[Change]:
        """Move each endpoint to the node that claims it now; hide endpoints that no node claims any more."""
        for gid, found in participant.found.items():
            owner, shown = participant.owners.get(gid), participant.shown.get(gid)
            node_id = UNKNOWN_ID if owner is None else owner.entity.node_id
            if shown is not None and shown.node_id != node_id:
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


def _identify_nodes(participant: _Participant, told: tuple[NodeInfo, ...]) -> Iterator[_Node]:
    """Yield the announced nodes. A known node (by name, of namesakes by endpoints) keeps its entity."""
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
