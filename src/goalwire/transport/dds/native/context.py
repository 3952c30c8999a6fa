"""The things that all endpoints of one session share: the participant, the graph, the announcement."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.fault_reports import RejectCounters
from goalwire.records import replace
from goalwire.rtps.io.session import RtpsSession
from goalwire.rtps.protocol.primitives import PARTICIPANT
from goalwire.rtps.protocol.writer import WriterListener
from goalwire.transport.dds.announcement import READ, WRITTEN, Announcement
from goalwire.transport.dds.description import DISCOVERY_TOPIC, DISCOVERY_TYPE, encode_participant
from goalwire.transport.dds.native.discovery import GraphDiscovery, InfoListener
from goalwire.transport.dds.native.qos import reader_qos, writer_qos
from goalwire.transport.dds.native.rmw import RmwDefaults
from goalwire.transport.dds.notifier import GraphNotifier
from goalwire.transport.dds.session import DdsContext
from goalwire.transport.dds.settings.session import asks_whom_the_standard_names, session_settings


class NativeContext(DdsContext):
    """One participant, its view of the graph, and its announcement."""

    def __init__(self, domain_id: int, enclave: str, defaults: RmwDefaults) -> None:
        """Join the domain; raises TransportError."""
        self.defaults = defaults
        self.rejects = RejectCounters()
        self.notifier = GraphNotifier()
        self.awaited: dict[object, None] = {}
        """The calls of all clients that wait for an answer."""
        self.discovery = GraphDiscovery(domain_id, self.notifier, self.rejects, self.call_later)
        settings = session_settings(domain_id, defaults.identifier, lease_s=defaults.lease_s)
        self.discovery.expects_ports = asks_whom_the_standard_names(settings)
        self.rtps = RtpsSession(
            replace(settings, user_data=encode_participant(enclave), name=enclave),
            self.discovery,
            rejects=self.rejects,
            awaited=self.awaited,
            starts=False,
        )
        self.guard = self.rtps.guard
        self.participant = self.rtps.participant
        self.wire_poller = self.rtps.wire_poller
        super().__init__(self.participant.prefix + PARTICIPANT, domain_id, enclave)
        self.announcement = Announcement(self.guid)
        create = self.participant
        about = DISCOVERY_TOPIC, DISCOVERY_TYPE
        self._writer = create.create_writer(*about, writer_qos(WRITTEN, defaults), WriterListener())
        listener = InfoListener(create.prefix, self.discovery)
        create.create_reader(*about, reader_qos(READ, defaults), listener)
        self.announce()
        self.rtps.start()

    def call_later(self, delay_s: float, function: Callable[[], None]) -> None:
        """Call a function after `delay_s` as listeners are called: in order, with no lock held."""
        participant = self.participant

        def tell() -> None:
            participant.tell(function)

        participant.run(lambda: participant.timers.at(participant.clock() + delay_s, tell), None)

    def announce(self) -> None:
        """Publish the announcement if it has changed."""
        self.participant.run(self._publish, None)

    def _publish(self) -> None:
        told = self.announcement.take()
        if told is not None:
            self._writer.add(told)

    def has_heard_all(self) -> bool:
        """Return whether all participants, known or on this machine, have announced everything."""
        return self.discovery.has_heard_all()

    def close(self) -> None:
        """Leave the domain."""
        self.notifier.close()
        self.rtps.close()
