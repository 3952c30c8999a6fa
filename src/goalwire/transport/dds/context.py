"""What every endpoint of one session shares."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

from goalwire.transport.dds.abi import Library
from goalwire.transport.dds.configuration import calls_fast_dds
from goalwire.transport.dds.discovery import Discovery
from goalwire.transport.dds.domain import DOMAINS, open_domain
from goalwire.transport.dds.graph_notifier import GraphNotifier
from goalwire.transport.dds.peers import Peers
from goalwire.transport.dds.status import Statuses
from goalwire.transport.dds.user_data import encode_participant, service_id
from goalwire.transport.dds.wire import Participant
from goalwire.transport.dds.wire_poller import DdsWirePoller
from goalwire.transport.endpoint import ForkGuard
from goalwire.transport.reports import RejectCounters

if TYPE_CHECKING:
    from goalwire.transport.dds.fast_dds import Translation


class DdsContext:
    """One participant, its two threads and what they know."""

    def __init__(self, library: Library, domain_id: int, enclave: str) -> None:
        """Join the domain; raises TransportError."""
        self.library = library
        self.domain_id = domain_id
        self.enclave = enclave
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        self.notifier = GraphNotifier()
        self.translation = _translation(library)
        domain = open_domain(library, domain_id)
        try:
            self.participant = Participant(library, domain_id, encode_participant(enclave))
            self.id = self.participant.guid.hex()
            self.peers = Peers(library)
            self.local_readers = domain.local_readers
            self.wire_poller = DdsWirePoller(self.participant, 'goalwire-dds-io')
            self.discovery = Discovery(self.participant, self.notifier, self.rejects)
        except BaseException:
            self._leave()
            raise
        self.statuses = Statuses(library, self.discovery.waitset_thread)
        self.announcement = self.discovery.announcement
        self.next_id = count().__next__
        self._next_service = count(1).__next__

    def next_service_id(self) -> str:
        """Return what the two ends of one more client or server share."""
        return service_id(self.participant.guid, self._next_service())

    def announce(self) -> None:
        """Have the others told of what has changed here."""
        self.discovery.waitset_thread.wake()

    def close(self) -> None:
        """Stop the threads and leave the domain."""
        self.notifier.close()
        self.wire_poller.close()
        self.discovery.close()
        self._leave()

    def _leave(self) -> None:
        participant = getattr(self, 'participant', None)
        if participant is not None:
            participant.close()
        DOMAINS.close(self.domain_id)


def _translation(library: Library) -> Translation | None:
    """Return what lets clients call servers on Fast DDS, where the environment asks for it."""
    if not calls_fast_dds():
        return None
    from goalwire.transport.dds.fast_dds import translation

    return translation(library)
