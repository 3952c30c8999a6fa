"""Discovery on DDS: follows the other participants, and announces the nodes of this one.

A thread listens to the library's own topics and to ros_discovery_info. It publishes this participant's
announcement after each change. Listeners of the graph first hear of what is there, then of each change, in
order, with no lock held.
"""

from __future__ import annotations

import ctypes
import socket
from collections.abc import Iterator
from ctypes import c_void_p
from typing import TypeVar

from goalwire.errors import RemoteError
from goalwire.fault_reports import RejectCounters
from goalwire.rules.qos import DEFAULT
from goalwire.transport.dds.announcement import READ, WRITTEN, Announcement
from goalwire.transport.dds.cyclone.abi import (
    ALIVE,
    ANY_STATE,
    PARTICIPANTS,
    PUBLICATIONS,
    SUBSCRIPTIONS,
    BuiltinEndpoint,
    BuiltinParticipant,
    SampleInfo,
)
from goalwire.transport.dds.cyclone.qos import endpoint_qos, read_ports, read_qos, read_user_data
from goalwire.transport.dds.cyclone.waitset import WaitsetThread
from goalwire.transport.dds.cyclone.wire import Participant, Reader, Writer, check
from goalwire.transport.dds.description import (
    DISCOVERY_TOPIC,
    DISCOVERY_TYPE,
    Role,
    decode_endpoint,
    enclave_of,
    ros_topic,
    ros_type,
)
from goalwire.transport.dds.discovery_state import (
    DiscoveryState,
    Found,
    decode_info,
)
from goalwire.transport.dds.environment import ports_in_use
from goalwire.transport.dds.notifier import GraphNotifier
from goalwire.transport.graph_dispatcher import Change
from goalwire.transport.graph_names import check_names

_BLOCKING_NS = 1_000_000_000
"""How long a peer that does not acknowledge may delay an announcement, which then waits for the next
change."""


class Publication:
    """The writer of this session's announcement and the reader of the others' on ros_discovery_info."""

    def __init__(self, participant: Participant) -> None:
        self.announcement = Announcement(participant.guid)
        with endpoint_qos(participant.library, WRITTEN, b'', blocking_ns=_BLOCKING_NS) as qos:
            self._writer = Writer(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)
        with endpoint_qos(participant.library, READ, b'', ignore_local=True) as qos:
            self.reader = Reader(participant, DISCOVERY_TOPIC, DISCOVERY_TYPE, qos)

    def publish(self) -> None:
        """Publish the announcement if anything has changed. Only one thread calls this."""
        told = self.announcement.take()
        if told is not None and self._writer.write(told) < 0:
            self.announcement.put_back()


GRACE_NS = 1_000_000_000
"""How long the graph waits for an endpoint's node to be announced before it shows the endpoint."""
_AT_ONCE = 64

B = TypeVar('B', BuiltinEndpoint, BuiltinParticipant)


class Discovery:
    """Keeps the graph up to date with the others' announcements, and announces what this session has."""

    def __init__(
        self, participant: Participant, domain_id: int, notifier: GraphNotifier, rejects: RejectCounters
    ) -> None:
        self._participant = participant
        self._domain_id = domain_id
        self._host = socket.gethostname()
        self._ports: dict[bytes, frozenset[int] | None] = {}
        """The discovery ports of each known participant; None if it announces none: see read_ports."""
        self._is_telling = False
        """True while listeners may not have heard of the latest changes."""
        self._library = participant.library
        self._notifier = notifier
        self._rejects = rejects
        self._state_of_discovery = DiscoveryState()
        self._waiting: frozenset[bytes] = frozenset()
        self._publication = Publication(participant)
        self.announcement = self._publication.announcement
        self.waitset_thread = WaitsetThread(participant, 'goalwire-dds-discovery')
        self.waitset_thread.on_wake(self._publication.publish)
        self._readers = [self._builtin(topic) for topic in (PUBLICATIONS, SUBSCRIPTIONS, PARTICIPANTS)]
        for condition in (*(condition for _, condition in self._readers), self._publication.reader.condition):
            self.waitset_thread.watch(condition, self._look)
        self.waitset_thread.wake()  # announces that there are no nodes yet

    def _builtin(self, topic: int) -> tuple[int, int]:
        library = self._library
        reader = library.dds_create_reader(self._participant.handle, topic, None, None)
        check(library, reader, 'discovery')
        return reader, library.dds_create_readcondition(reader, ANY_STATE)

    def close(self) -> None:
        """Stop listening."""
        self.waitset_thread.close()

    def has_heard_all(self) -> bool:
        """Return whether all known participants have announced their nodes and endpoints. Any thread.

        A process on this machine that holds a port of the domain counts as known even before it is heard: it
        has been asked, and will answer.
        """
        told = list(self._ports.values())
        missing = ports_in_use(self._domain_id).difference(*filter(None, told))
        # Each participant that announces no ports may hold one of the missing ports.
        if len(missing) > told.count(None):
            return False
        # The state is read first: `_is_telling` is reset only after the listeners know what completed the
        # state.
        return self._state_of_discovery.is_complete() and not self._is_telling

    def _look(self) -> None:
        self._is_telling = True
        try:
            self._take_all()
        finally:
            self._is_telling = False

    def _take_all(self) -> None:
        """Take all changes; participants are read last and reported first, before their endpoints."""
        infos = self._infos()
        (publications, _), (subscriptions, _), (participants, _) = self._readers
        came: list[Found] = []
        gone: list[bytes] = []
        for reader, is_reader in ((publications, False), (subscriptions, True)):
            for is_there, endpoint in self._take(reader, BuiltinEndpoint):
                if not is_there:
                    gone.append(bytes(endpoint.key))
                elif (found := self._find(endpoint, is_reader=is_reader)) is not None:
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
                changes += discovered.learn(decode_info(payload))
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
            count, messages = self._publication.reader.take()
            infos += [message.payload for message in messages]
            if not count:
                return infos

    def _take_participants(self, reader: int) -> list[bytes]:
        """Add the new participants; return those that have gone."""
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
        """Yield each change: whether the entity exists, and its record, valid until the next step."""
        samples, infos = (c_void_p * _AT_ONCE)(), (SampleInfo * _AT_ONCE)()
        while True:
            samples[0] = None  # NULL asks the library to lend its own samples
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

    def _find(self, endpoint: BuiltinEndpoint, *, is_reader: bool) -> Found | None:
        """Return an endpoint in ROS 2's terms; None if it is this session's own, or outside ROS 2."""
        participant = bytes(endpoint.participant)
        if participant == self._participant.guid:
            return None
        gid, topic = bytes(endpoint.key), endpoint.topic_name.decode(errors='replace')
        named = ros_topic(topic)
        if topic == DISCOVERY_TOPIC:
            # This topic is hidden in the graph, as replies are; it shows that the participant speaks ROS 2.
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
        # A service's ends announce the hash of the request or of the response, not of the service type.
        type_hash = data.type_hash if named.role is Role.TOPIC else ''
        return Found(gid, participant, named.role, is_reader, named.name, type_name, type_hash, qos)

    def _wait_for_claims(self) -> None:
        """Set a timer at whose end the endpoints that no node has claimed are shown without a node."""
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
