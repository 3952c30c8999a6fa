"""Discovery on DDS: follows the other participants, and announces the nodes of this one.

A thread listens to the library's own topics and to ros_discovery_info. It publishes this participant's
announcement after each change. Listeners of the graph first hear of what is there, then of each change, in
order, with no lock held.
"""

from __future__ import annotations

import ctypes
import os
import socket
from collections.abc import Callable, Iterable, Iterator
from ctypes import c_void_p
from threading import Lock
from typing import TypeVar

from goalwire.errors import RemoteError
from goalwire.reports import RejectCounters
from goalwire.rules.qos import DEFAULT, DurabilityPolicy, HistoryPolicy, QoS
from goalwire.transport.contract import EndpointKind, GraphEntity, GraphListener, NodeName
from goalwire.transport.dds.abi import (
    ALIVE,
    ANY_STATE,
    PARTICIPANTS,
    PUBLICATIONS,
    SUBSCRIPTIONS,
    BuiltinEndpoint,
    BuiltinParticipant,
    SampleInfo,
)
from goalwire.transport.dds.configuration import ports_in_use
from goalwire.transport.dds.description import (
    DISCOVERY_TOPIC,
    DISCOVERY_TYPE,
    Role,
    decode_endpoint,
    enclave_of,
    endpoint_qos,
    read_ports,
    read_qos,
    read_user_data,
    ros_topic,
    ros_type,
)
from goalwire.transport.dds.discovery_state import (
    GID_SIZE,
    OLD_GID_SIZE,
    UNKNOWN_ID,
    DiscoveryState,
    Found,
    NodeInfo,
    ParticipantInfo,
    decode_info,
    encode_info,
)
from goalwire.transport.dds.waitset import WaitsetThread
from goalwire.transport.dds.wire import Participant, Reader, Writer, check
from goalwire.transport.graph_dispatcher import Change, GraphDispatcher, graph_dispatcher
from goalwire.transport.graph_names import check_names


class GraphNotifier:
    """Tells listeners what is in the graph, and how it changes."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._there: dict[tuple[EndpointKind, str, int, bytes], GraphEntity] = {}
        self._watchers: tuple[GraphDispatcher, ...] = ()
        self._awaited: list[tuple[bytes, Callable[[NodeName], None]]] = []

    def watch(self, listener: GraphListener) -> None:
        """Call a listener with all there is, before this returns, and with every change until `close`."""
        watcher = graph_dispatcher(listener)
        with watcher.first_turn(), self._lock:
            for entity in self._there.values():
                watcher.post((True, entity))
            self._watchers += (watcher,)

    def change(self, changes: Iterable[Change]) -> None:
        """Note changes and tell the listeners."""
        with self._lock:
            for change in changes:
                self._note(change)
            watchers = self._watchers
            shown = list(self._shown()) if self._awaited else ()
        for watcher in watchers:
            watcher.drain()
        for node, tell in shown:
            tell(node)

    def _note(self, change: Change) -> None:
        is_there, entity = change
        key = entity.kind, entity.session, entity.node_id, entity.gid
        if is_there:
            self._there[key] = entity
        else:
            self._there.pop(key, None)
        for watcher in self._watchers:
            watcher.post(change)

    def when_shown(self, gid: bytes, tell: Callable[[NodeName], None]) -> None:
        """Call `tell` with the node of an endpoint once that is known, which may be at once, or never."""
        with self._lock:
            self._awaited.append((gid, tell))
            shown = list(self._shown())
        for node, told in shown:
            told(node)

    def _shown(self) -> Iterator[tuple[NodeName, Callable[[NodeName], None]]]:
        """Yield the endpoints that wait no longer, each with its node."""
        known = (entity for entity in self._there.values() if entity.node_id != UNKNOWN_ID)
        nodes = {entity.gid: entity.node for entity in known}
        for awaited in list(self._awaited):
            gid, tell = awaited
            if gid in nodes:
                self._awaited.remove(awaited)
                yield nodes[gid], tell

    def connected(self) -> None:
        """An endpoint of this session was connected with another, or disconnected."""
        with self._lock:
            watchers = self._watchers
            for watcher in watchers:
                watcher.post(None)
        for watcher in watchers:
            watcher.drain()

    def close(self) -> None:
        """Remove the listener."""
        with self._lock:
            self._watchers = ()


_WRITTEN = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_READ = QoS(history=HistoryPolicy.KEEP_ALL, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_OLD = frozenset({'dashing', 'eloquent', 'foxy', 'galactic', 'humble'})
_BLOCKING_NS = 1_000_000_000
"""How long a mute peer may hold an announcement up; it is then made with the next change."""


def gid_size() -> int:
    """Return how long Gids are in the ROS 2 that ROS_DISTRO names."""
    return OLD_GID_SIZE if os.environ.get('ROS_DISTRO', '').strip() in _OLD else GID_SIZE


class Announcement:
    """The nodes of a session and their endpoints, published by `publish` after each change."""

    def __init__(self, participant: Participant) -> None:
        self._guid = participant.guid
        self._gid_size = gid_size()
        self._lock = Lock()
        self._nodes: dict[int, tuple[NodeName, dict[bytes, None], dict[bytes, None]]] = {}
        self._changed = True  # a session without nodes tells so: else others would wait for it to tell them
        with endpoint_qos(participant.library, _WRITTEN, b'', blocking_ns=_BLOCKING_NS) as qos:
            self._writer = Writer(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)
        with endpoint_qos(participant.library, _READ, b'', ignore_local=True) as qos:
            self.reader = Reader(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)

    def add_node(self, node_id: int, name: NodeName) -> None:
        """A node has come."""
        with self._lock:
            self._nodes[node_id] = name, {}, {}
            self._changed = True

    def remove_node(self, node_id: int) -> None:
        """A node has gone; an unknown one is not an error."""
        with self._lock:
            self._nodes.pop(node_id, None)
            self._changed = True

    def add(self, node_id: int, readers: Iterable[bytes], writers: Iterable[bytes]) -> None:
        """Endpoints of a node have come."""
        with self._lock:
            _, all_readers, all_writers = self._nodes[node_id]
            all_readers.update(dict.fromkeys(readers))
            all_writers.update(dict.fromkeys(writers))
            self._changed = True

    def remove(self, node_id: int, gids: Iterable[bytes]) -> None:
        """Endpoints of a node have gone; unknown ones are no error."""
        with self._lock:
            if node_id not in self._nodes:
                return
            _, readers, writers = self._nodes[node_id]
            for gid in gids:
                readers.pop(gid, None)
                writers.pop(gid, None)
            self._changed = True

    def publish(self) -> None:
        """Publish the announcement if anything has changed. Only one thread calls this."""
        with self._lock:
            if not self._changed:
                return
            self._changed = False
            nodes = tuple(
                NodeInfo(name.namespace, name.name, tuple(readers), tuple(writers))
                for name, readers, writers in self._nodes.values()
            )
        if self._writer.write(encode_info(ParticipantInfo(self._guid, nodes), self._gid_size)) < 0:
            with self._lock:
                self._changed = True


GRACE_NS = 1_000_000_000
"""How long an endpoint waits for its node to be told."""
_AT_ONCE = 64

B = TypeVar('B', BuiltinEndpoint, BuiltinParticipant)


class Discovery:
    """Keeps the graph up to date with what the others have, and the others with what this session has."""

    def __init__(
        self, participant: Participant, domain_id: int, notifier: GraphNotifier, rejects: RejectCounters
    ) -> None:
        self._participant = participant
        self._domain_id = domain_id
        self._host = socket.gethostname()
        self._ports: dict[bytes, frozenset[int] | None] = {}
        """Of each participant that was met: see read_ports."""
        self._is_telling = False
        """True while what has changed in the state may not have been told yet."""
        self._library = participant.library
        self._notifier = notifier
        self._rejects = rejects
        self._state_of_discovery = DiscoveryState()
        self._waiting: frozenset[bytes] = frozenset()
        self.announcement = Announcement(participant)
        self.waitset_thread = WaitsetThread(participant, 'goalwire-dds-discovery')
        self.waitset_thread.on_wake(self.announcement.publish)
        self._readers = [self._builtin(topic) for topic in (PUBLICATIONS, SUBSCRIPTIONS, PARTICIPANTS)]
        for condition in (*(condition for _, condition in self._readers), self.announcement.reader.condition):
            self.waitset_thread.watch(condition, self._look)
        self.waitset_thread.wake()  # tells that there are no nodes yet

    def _builtin(self, topic: int) -> tuple[int, int]:
        library = self._library
        reader = library.dds_create_reader(self._participant.handle, topic, None, None)
        check(library, reader, 'discovery')
        return reader, library.dds_create_readcondition(reader, ANY_STATE)

    def close(self) -> None:
        """Listen no more."""
        self.waitset_thread.close()

    def has_heard_all(self) -> bool:
        """Whether all participants that were met have told their nodes and endpoints. Any thread.

        Those count, too, that were not met yet and have a port of the domain on this machine: they have been
        asked, and will answer.
        """
        told = list(self._ports.values())
        missing = ports_in_use(self._domain_id).difference(*filter(None, told))
        if len(missing) > told.count(None):  # who does not tell a port may have one of these
            return False
        # In this order: what completed the state has been told to the listeners once that is over.
        return self._state_of_discovery.is_complete() and not self._is_telling

    def _look(self) -> None:
        self._is_telling = True
        try:
            self._take_all()
        finally:
            self._is_telling = False

    def _take_all(self) -> None:
        """Take what is new. Participants are taken last and told first: so each endpoint's is known."""
        infos = self._infos()
        (publications, _), (subscriptions, _), (participants, _) = self._readers
        came: list[Found] = []
        gone: list[bytes] = []
        for reader, is_reader in ((publications, False), (subscriptions, True)):
            for is_there, endpoint in self._take(reader, BuiltinEndpoint):
                if not is_there:
                    gone.append(bytes(endpoint.key))
                elif (found := self._found(endpoint, is_reader=is_reader)) is not None:
                    came.append(found)
        departed = self._take_participants(participants)
        self._tell(came, infos, gone, departed)

    def _tell(
        self,
        came: list[Found],
        infos: list[bytes],
        gone: list[bytes],
        departed: list[bytes],
    ) -> None:
        discovered = self._state_of_discovery
        changes: list[Change] = []
        for found in came:
            if found.name == DISCOVERY_TOPIC:
                discovered.ros_speaker_came(found.participant)
        for found in came:
            changes += discovered.endpoint_came(found)
        for payload in infos:
            try:
                changes += discovered.told(decode_info(payload))
            except RemoteError as error:
                self._rejects.add('ros_discovery_info', error)
        for gid in gone:
            changes += discovered.endpoint_went(gid)
        for guid in departed:
            changes += discovered.participant_went(guid)
        self._notifier.change(changes)
        self._wait_for_claims()

    def _infos(self) -> list[bytes]:
        infos = []
        while True:
            count, messages = self.announcement.reader.take()
            infos += [message.payload for message in messages]
            if not count:
                return infos

    def _take_participants(self, reader: int) -> list[bytes]:
        """Note the participants that came; return those that went."""
        departed = []
        for is_there, participant in self._take(reader, BuiltinParticipant):
            guid = bytes(participant.key)
            if guid == self._participant.guid:
                continue
            if is_there:
                enclave = enclave_of(read_user_data(self._library, participant.qos))
                self._state_of_discovery.participant_came(guid, enclave)
                self._ports[guid] = read_ports(self._library, participant.qos, self._host)
            else:
                self._ports.pop(guid, None)
                departed.append(guid)
        return departed

    def _take(self, reader: int, kind: type[B]) -> Iterator[tuple[bool, B]]:
        """Yield each new state: whether it is there, and the record, to be read at once."""
        samples, infos = (c_void_p * _AT_ONCE)(), (SampleInfo * _AT_ONCE)()
        while True:
            samples[0] = None  # asks for a loan
            count = self._library.dds_take(reader, samples, infos, _AT_ONCE, _AT_ONCE)
            if count <= 0:
                return
            try:
                for index in range(count):
                    record = ctypes.cast(samples[index] or 0, ctypes.POINTER(kind)).contents
                    alive = infos[index].instance_state == ALIVE
                    if infos[index].valid_data or not alive:
                        yield alive, record
            finally:
                self._library.dds_return_loan(reader, samples, count)

    def _found(self, endpoint: BuiltinEndpoint, *, is_reader: bool) -> Found | None:
        """Return what an endpoint is in ROS 2; None for our own and for what has no place there."""
        participant = bytes(endpoint.participant)
        if participant == self._participant.guid:
            return None
        gid, topic = bytes(endpoint.key), endpoint.topic_name.decode(errors='replace')
        named = ros_topic(topic)
        if topic == DISCOVERY_TOPIC:
            # The graph shows no replies, nor this; but it tells that its participant speaks ROS 2.
            return Found(gid, participant, Role.REPLY, is_reader, topic, '', '', DEFAULT)
        if named is None:
            return None
        type_name = ros_type(named.role, endpoint.type_name.decode(errors='replace'))
        try:
            check_names('topic or type', named.name, type_name)
        except RemoteError as error:
            self._rejects.add('DDS endpoint', error)
            return None
        qos = read_qos(self._library, endpoint.qos, verbatim=topic == named.name)
        data = decode_endpoint(read_user_data(self._library, endpoint.qos))
        type_hash = data.type_hash if named.role is Role.TOPIC else ''  # else that of one half of a service
        return Found(gid, participant, named.role, is_reader, named.name, type_name, type_hash, qos)

    def _wait_for_claims(self) -> None:
        """See to it that endpoints which no node claims are shown in the end."""
        if self._state_of_discovery.unclaimed and not self._waiting:
            self._waiting = frozenset(self._state_of_discovery.unclaimed)
            self.waitset_thread.call_in(GRACE_NS, self._show_unclaimed)

    def _show_unclaimed(self) -> None:
        waiting, self._waiting = self._waiting, frozenset()
        self._is_telling = True
        try:
            self._notifier.change(self._state_of_discovery.show_unclaimed(waiting))
        finally:
            self._is_telling = False
        self._wait_for_claims()
