"""Makes the graph from RTPS discovery and from the other participants' ros_discovery_info.

The participant's listeners call everything here, one call after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from goalwire.errors import RemoteError
from goalwire.fault_reports import RejectCounters
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
"""How long an endpoint waits for the announcement of its node."""


class GraphDiscovery(ParticipantListener):
    """Keeps the graph up to date with the other participants' nodes and endpoints."""

    def __init__(
        self,
        domain_id: int,
        notifier: GraphNotifier,
        rejects: RejectCounters,
        call_later: Callable[[float, Callable[[], None]], None],
    ) -> None:
        """`call_later` calls a function after so many seconds, on the thread that calls listeners."""
        self._domain_id = domain_id
        self.expects_ports = True
        """True if participants on this machine are asked at the domain's ports, so that they will answer."""
        self._notifier = notifier
        self._rejects = rejects
        self._call_later = call_later
        self._state = DiscoveryState()
        self._is_telling = False
        """True while listeners may not have heard of the latest changes."""
        self._waiting: frozenset[bytes] = frozenset()
        self._ports: dict[bytes, frozenset[int]] = {}
        """The ports at which each known participant listens for discovery."""

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
            found = _find(endpoint)
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
        """Take over a participant's announcement of its nodes."""
        try:
            info = decode_info(payload)
        except RemoteError as error:
            self._rejects.add('ros_discovery_info', error)
            return
        with self._telling() as changes:
            changes += self._state.learn(info)
        self._wait_for_claims()

    def _wait_for_claims(self) -> None:
        """Set a timer at whose end the endpoints that no node has claimed are shown without a node."""
        if self._state.unclaimed and not self._waiting:
            self._waiting = frozenset(self._state.unclaimed)
            self._call_later(GRACE_S, self._show_unclaimed)

    def _show_unclaimed(self) -> None:
        waiting, self._waiting = self._waiting, frozenset()
        with self._telling() as changes:
            changes += self._state.show_unclaimed(waiting)
        self._wait_for_claims()

    def has_heard_all(self) -> bool:
        """Return whether all known participants have announced their nodes and endpoints. Any thread.

        A process on this machine that holds a port of the domain counts as known even before it is heard: it
        has been asked, and will answer.
        """
        expected = ports_in_use(self._domain_id) if self.expects_ports else set()
        if expected.difference(*self._ports.copy().values()):
            return False
        # The state is read first: `_is_telling` is reset only after the listeners know what completed the
        # state.
        return self._state.is_complete() and not self._is_telling


class InfoListener(ReaderListener):
    """Reads the ros_discovery_info of the other participants."""

    def __init__(self, prefix: bytes, discovery: GraphDiscovery) -> None:
        self._prefix = prefix
        self._discovery = discovery

    def on_sample(self, sample: Sample) -> None:
        if sample.payload is not None and sample.writer[:GUID_PREFIX_SIZE] != self._prefix:
            self._discovery.on_info(bytes(sample.payload))


def _ports(addresses: tuple[Address, ...]) -> frozenset[int]:
    return frozenset(port for _, port in addresses)


def _find(endpoint: EndpointData) -> Found | None:
    """Return an endpoint in ROS 2's terms; None for endpoints outside ROS 2. Raises RemoteError."""
    participant, topic = endpoint.prefix + PARTICIPANT, endpoint.topic
    is_reader = not is_writer(endpoint.entity_id)
    if topic == DISCOVERY_TOPIC:
        # This topic is hidden in the graph, as replies are; it shows that the participant speaks ROS 2.
        return Found(endpoint.guid, participant, Role.REPLY, is_reader, topic, '', '', DEFAULT)
    named = ros_topic(topic)
    if named is None:
        return None
    type_name = ros_type(named.role, endpoint.type_name)
    check_names('topic or type', named.name, type_name)
    qos = ros_qos(endpoint.qos, verbatim=topic == named.name)
    told = decode_endpoint(endpoint.user_data)
    # For a service it would be the hash of the request or of the response, not of the service type.
    type_hash = told.type_hash if named.role is Role.TOPIC else ''
    return Found(endpoint.guid, participant, named.role, is_reader, named.name, type_name, type_hash, qos)
