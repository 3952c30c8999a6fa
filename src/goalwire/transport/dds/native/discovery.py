"""What RTPS discovers, and what others tell by ros_discovery_info, becomes the graph.

Everything here is called by the participant's listeners, one call after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from goalwire.errors import RemoteError
from goalwire.reports import RejectCounters
from goalwire.rtps.protocol.announcements import EndpointData, ParticipantData
from goalwire.rtps.protocol.discovery import ParticipantListener
from goalwire.rtps.protocol.primitives import PARTICIPANT, Address, is_writer
from goalwire.rtps.protocol.reader import ReaderListener, Sample
from goalwire.rules.qos import DEFAULT
from goalwire.transport.dds.description import (
    DISCOVERY_TOPIC,
    GUID_PREFIX_SIZE,
    Role,
    decode_endpoint,
    enclave_of,
    ros_topic,
    ros_type,
)
from goalwire.transport.dds.discovery_state import DiscoveryState, Found, decode_info
from goalwire.transport.dds.environment import ports_in_use
from goalwire.transport.dds.native.qos import ros_qos
from goalwire.transport.dds.notifier import GraphNotifier
from goalwire.transport.graph_dispatcher import Change
from goalwire.transport.graph_names import check_names

GRACE_S = 1.0
"""How long an endpoint waits for its node to be told."""


class GraphDiscovery(ParticipantListener):
    """Keeps the graph up to date with what the others have."""

    def __init__(
        self,
        domain_id: int,
        notifier: GraphNotifier,
        rejects: RejectCounters,
        call_later: Callable[[float, Callable[[], None]], None],
    ) -> None:
        """`call_later` calls a function after so many seconds, as listeners are called."""
        self._domain_id = domain_id
        self.expects_ports = True
        """Whether those who have a port of the domain on this machine are asked, and will answer."""
        self._notifier = notifier
        self._rejects = rejects
        self._call_later = call_later
        self._state = DiscoveryState()
        self._is_telling = False
        """True while what has changed in the state may not have been told yet."""
        self._waiting: frozenset[bytes] = frozenset()
        self._ports: dict[bytes, frozenset[int]] = {}
        """Where each participant that was met listens for discovery."""

    @contextmanager
    def _telling(self) -> Iterator[list[Change]]:
        changes: list[Change] = []
        self._is_telling = True
        try:
            yield changes
            self._notifier.change(changes)
        finally:
            self._is_telling = False

    def on_participant(self, participant: ParticipantData) -> None:
        guid = participant.prefix + PARTICIPANT
        self._ports[guid] = _ports(participant.metatraffic)
        self._state.participant_came(guid, enclave_of(participant.user_data))

    def on_participant_lost(self, participant: ParticipantData) -> None:
        guid = participant.prefix + PARTICIPANT
        self._ports.pop(guid, None)
        with self._telling() as changes:
            changes += self._state.participant_went(guid)

    def on_endpoint(self, endpoint: EndpointData) -> None:
        try:
            found = _found(endpoint)
        except RemoteError as error:
            self._rejects.add('DDS endpoint', error)
            return
        if found is None:
            return
        if found.name == DISCOVERY_TOPIC:
            self._state.ros_speaker_came(found.participant)
        with self._telling() as changes:
            changes += self._state.endpoint_came(found)
        self._wait_for_claims()

    def on_endpoint_lost(self, endpoint: EndpointData) -> None:
        with self._telling() as changes:
            changes += self._state.endpoint_went(endpoint.guid)

    def on_info(self, payload: bytes) -> None:
        """A participant tells its nodes."""
        try:
            info = decode_info(payload)
        except RemoteError as error:
            self._rejects.add('ros_discovery_info', error)
            return
        with self._telling() as changes:
            changes += self._state.told(info)
        self._wait_for_claims()

    def _wait_for_claims(self) -> None:
        """See to it that endpoints which no node claims are shown in the end."""
        if self._state.unclaimed and not self._waiting:
            self._waiting = frozenset(self._state.unclaimed)
            self._call_later(GRACE_S, self._show_unclaimed)

    def _show_unclaimed(self) -> None:
        waiting, self._waiting = self._waiting, frozenset()
        with self._telling() as changes:
            changes += self._state.show_unclaimed(waiting)
        self._wait_for_claims()

    def has_heard_all(self) -> bool:
        """Whether all participants that were met have told their nodes and endpoints. Any thread.

        Those count, too, that were not met yet and have a port of the domain on this machine: they have been
        asked, and will answer.
        """
        expected = ports_in_use(self._domain_id) if self.expects_ports else set()
        if expected.difference(*self._ports.copy().values()):
            return False
        # In this order: what completed the state has been told to the listeners once that is over.
        return self._state.is_complete() and not self._is_telling


class InfoListener(ReaderListener):
    """Reads ros_discovery_info, but for the participant's own."""

    def __init__(self, prefix: bytes, discovery: GraphDiscovery) -> None:
        self._prefix = prefix
        self._discovery = discovery

    def on_sample(self, sample: Sample) -> None:
        if sample.payload is not None and sample.writer[:GUID_PREFIX_SIZE] != self._prefix:
            self._discovery.on_info(sample.payload)


def _ports(addresses: tuple[Address, ...]) -> frozenset[int]:
    return frozenset(port for _, port in addresses)


def _found(endpoint: EndpointData) -> Found | None:
    """Return what an endpoint is in ROS 2; None for what has no place there. Raises RemoteError."""
    participant, topic = endpoint.prefix + PARTICIPANT, endpoint.topic
    is_reader = not is_writer(endpoint.entity_id)
    if topic == DISCOVERY_TOPIC:
        # The graph hides this topic, as it hides replies. It shows that the participant speaks ROS 2.
        return Found(endpoint.guid, participant, Role.REPLY, is_reader, topic, '', '', DEFAULT)
    named = ros_topic(topic)
    if named is None:
        return None
    type_name = ros_type(named.role, endpoint.type_name)
    check_names('topic or type', named.name, type_name)
    qos = ros_qos(endpoint.qos, verbatim=topic == named.name)
    told = decode_endpoint(endpoint.user_data)
    type_hash = told.type_hash if named.role is Role.TOPIC else ''  # else that of one half of a service
    return Found(endpoint.guid, participant, named.role, is_reader, named.name, type_name, type_hash, qos)
