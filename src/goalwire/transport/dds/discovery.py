"""What DDS itself tells of the other participants and their endpoints, and the thread that listens to it."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from ctypes import c_void_p
from typing import TypeVar

from goalwire.errors import RemoteError
from goalwire.rules.qos import DEFAULT
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
from goalwire.transport.dds.announcement import Announcement
from goalwire.transport.dds.discovery_state import Change, DiscoveryState, Found
from goalwire.transport.dds.graph_notifier import GraphNotifier
from goalwire.transport.dds.names import DISCOVERY_TOPIC, Role, ros_topic, ros_type
from goalwire.transport.dds.participant_info import decode
from goalwire.transport.dds.qos import read_qos, read_user_data
from goalwire.transport.dds.user_data import decode_endpoint, enclave_of
from goalwire.transport.dds.waitset_thread import WaitsetThread
from goalwire.transport.dds.wire import Participant, check
from goalwire.transport.reports import RejectCounters, check_names

GRACE_NS = 1_000_000_000
"""How long an endpoint waits for its node to be told."""
_AT_ONCE = 64

B = TypeVar('B', BuiltinEndpoint, BuiltinParticipant)


class Discovery:
    """Keeps a feed up to date with what the others have, and the others with what this session has."""

    def __init__(self, participant: Participant, notifier: GraphNotifier, rejects: RejectCounters) -> None:
        self._participant = participant
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

    def _builtin(self, topic: int) -> tuple[int, int]:
        library = self._library
        reader = library.dds_create_reader(self._participant.handle, topic, None, None)
        check(library, reader, 'discovery')
        return reader, library.dds_create_readcondition(reader, ANY_STATE)

    def close(self) -> None:
        """Listen no more."""
        self.waitset_thread.close()

    def _look(self) -> None:
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
                changes += discovered.told(decode(payload))
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
            else:
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
            self.waitset_thread.call_in(GRACE_NS, self._lose_patience)

    def _lose_patience(self) -> None:
        waiting, self._waiting = self._waiting, frozenset()
        self._notifier.change(self._state_of_discovery.give_up_on(waiting))
        self._wait_for_claims()
