"""The domain, participant and threads that all endpoints of a session share; and how endpoints are made."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

from goalwire.concurrency.descriptors import LibrarysSockets
from goalwire.concurrency.forks import ForkGuard
from goalwire.errors import TransportError
from goalwire.fault_reports import RejectCounters
from goalwire.transport.dds.cyclone.abi import Library
from goalwire.transport.dds.cyclone.configuration import domain_configuration
from goalwire.transport.dds.cyclone.delivery import LocalReaders, ReaderDispatcher
from goalwire.transport.dds.cyclone.discovery import Discovery
from goalwire.transport.dds.cyclone.status import Peers, Statuses
from goalwire.transport.dds.cyclone.waitset import DdsWirePoller
from goalwire.transport.dds.cyclone.wire import Participant
from goalwire.transport.dds.description import encode_participant
from goalwire.transport.dds.environment import LARGEST_DOMAIN
from goalwire.transport.dds.notifier import GraphNotifier
from goalwire.transport.dds.session import DdsContext
from goalwire.transport.endpoint import EndpointState, Shared


class Domain(NamedTuple):
    """One domain, the readers of its sessions in this process, and its sockets."""

    library: Library
    handle: int
    local_readers: LocalReaders
    sockets: LibrarysSockets


DOMAINS: Shared[int, Domain] = Shared(lambda domain: domain.library.dds_delete(domain.handle))
"""The domains that sessions of this process are in, by domain id."""


def open_domain(library: Library, domain_id: int) -> Domain:
    """Return the domain for one more session, which calls `DOMAINS.close` later. Raises TransportError."""
    if domain_id > LARGEST_DOMAIN:
        raise TransportError(
            f'domain {domain_id} has no ports on DDS: set ROS_DOMAIN_ID to at most {LARGEST_DOMAIN}'
        )
    # A look-up of names may take seconds: so it is not done under the lock, and only if the domain is not
    # open yet.
    configuration = '' if DOMAINS.get(domain_id) else domain_configuration(domain_id)

    def make() -> Domain:
        text = (configuration or domain_configuration(domain_id)).encode()
        with LibrarysSockets() as sockets:
            handle = library.dds_create_domain(domain_id, text)
        if handle < 0:
            raise TransportError(
                f'Cyclone DDS refused the configuration of domain {domain_id} '
                f'({library.dds_strretcode(handle).decode()}): it has written why to standard error; '
                f'check CYCLONEDDS_URI and ROS_STATIC_PEERS'
            )
        return Domain(library, handle, LocalReaders(), sockets)

    return DOMAINS.open(domain_id, make)


class CycloneContext(DdsContext):
    """One participant, its two threads and the state that they keep."""

    def __init__(self, library: Library, domain_id: int, enclave: str) -> None:
        """Join the domain; raises TransportError."""
        self.library = library
        self.domain_id = domain_id
        self.guard = ForkGuard()
        self.rejects = RejectCounters()
        self.notifier = GraphNotifier()
        domain = open_domain(library, domain_id)
        try:
            self.participant = Participant(library, domain_id, encode_participant(enclave))
            super().__init__(self.participant.guid, domain_id, enclave)
            self.peers = Peers(library)
            self.local_readers = domain.local_readers
            self.wire_poller = DdsWirePoller(self.participant, 'goalwire-dds-io')
            self.discovery = Discovery(self.participant, domain_id, self.notifier, self.rejects)
        except BaseException:
            self._leave()
            raise
        self.statuses = Statuses(library, self.discovery.waitset_thread)
        self.announcement = self.discovery.announcement

    def announce(self) -> None:
        """Announce the changes of this session's nodes to the other participants."""
        self.discovery.waitset_thread.wake()

    def has_heard_all(self) -> bool:
        """Return whether all participants, known or on this machine, have announced everything."""
        return self.discovery.has_heard_all()

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


class EndpointBuilder:
    """The parts of one endpoint that are declared so far; `undo` has the steps that undeclare them."""

    __slots__ = ('_context', '_readers_to_watch', 'state', 'undo')

    def __init__(self, context: CycloneContext, state: EndpointState) -> None:
        self._context = context
        self._readers_to_watch: list[tuple[str, ReaderDispatcher]] = []
        self.state = state
        self.undo = state.undo

    def take_in(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Deliver a reader's messages as soon as the graph shows the endpoint, that is from `begin` on."""
        self._readers_to_watch.append((topic, dispatcher))

    def begin(self) -> None:
        """Begin to deliver messages: the graph shows the endpoint now."""
        context = self._context
        for topic, dispatcher in self._readers_to_watch:
            context.local_readers.add(topic, dispatcher)
            self.undo.append(partial(self._shut, topic, dispatcher))
            context.wire_poller.watch(dispatcher.reader.condition, dispatcher.drain)

    def _shut(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        dispatcher.closed = True
        self._context.local_readers.discard(topic, dispatcher)
        self._context.wire_poller.unwatch(dispatcher.reader.condition)
