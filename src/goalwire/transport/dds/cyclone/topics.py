"""Publishers and subscriptions on DDS."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import time_ns

from goalwire.errors import TransportError
from goalwire.rules.qos_events import EventStatus, EventType
from goalwire.transport.contract import Endpoint, Sample, new_sample
from goalwire.transport.dds.cyclone.abi import INFINITY
from goalwire.transport.dds.cyclone.context import CycloneContext, EndpointBuilder
from goalwire.transport.dds.cyclone.delivery import ReaderDispatcher
from goalwire.transport.dds.cyclone.qos import endpoint_qos
from goalwire.transport.dds.cyclone.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED
from goalwire.transport.dds.cyclone.wire import RawSample, Reader, Writer
from goalwire.transport.dds.description import EndpointData, Role, dds_topic, dds_type, encode_endpoint
from goalwire.transport.dds.session import PublisherEnd
from goalwire.transport.endpoint import OpenPort

NOT_COUNTED = 0
"""The sequence number of every message: DDS does not provide it."""


class DdsPublisher(PublisherEnd):
    """A declared publisher."""

    def __init__(self, context: CycloneContext, new: EndpointBuilder, endpoint: Endpoint) -> None:
        verbatim = endpoint.qos.avoid_ros_namespace_conventions
        topic = dds_topic(Role.TOPIC, endpoint.name, verbatim=verbatim)
        data = encode_endpoint(EndpointData(endpoint.type_hash))
        with endpoint_qos(context.library, endpoint.qos, data) as qos:
            writer = Writer(context.participant, topic, dds_type(Role.TOPIC, endpoint.type_name), qos)
        new.undo.append(writer.delete)
        new.undo.append(partial(context.statuses.discard, writer.handle))
        super().__init__(new.state, writer.guid)
        self.writer = writer
        self._context = context
        self._topic = topic
        self._write = writer.write
        self._local = context.local_readers.by_topic

    def publish(self, payload: bytes) -> None:
        """Write one message. If several threads publish at once, the order of their messages is undefined."""
        state = self.state
        if state.closed or state.guard.is_silent:
            state.check_sending()
        result = self._write(payload)
        if result:
            state.check()  # another thread may have closed the publisher in the meantime
            raise TransportError(
                f'{state.title}: Cyclone DDS refused a message: '
                f'{self._context.library.dds_strretcode(result).decode()}'
            )
        if self._topic in self._local:
            self._context.local_readers.drain(self._topic)

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Call `changed` with an event's totals; False if the library does not report this event."""
        return self._context.statuses.watch_event(self.writer.handle, event, changed)

    def peer_count(self) -> int:
        """Return how many endpoints the library has matched with this endpoint."""
        context = self._context
        return context.statuses.peers_of(self.writer.handle, PUBLICATION_MATCHED, context.notifier.connected)

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive, if its QoS leaves that to the user."""
        self.state.check_sending()
        self._context.library.dds_assert_liveliness(self.writer.handle)

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait until every reliable reader has received all messages; False if that takes too long."""
        self.state.check()
        patience = INFINITY if timeout_ns is None else timeout_ns
        return self._context.library.dds_wait_for_acks(self.writer.handle, patience) == 0


class DdsSubscription(OpenPort):
    """A declared subscription."""

    def __init__(
        self,
        context: CycloneContext,
        new: EndpointBuilder,
        endpoint: Endpoint,
        deliver: Callable[[Sample], None],
    ) -> None:
        verbatim = endpoint.qos.avoid_ros_namespace_conventions
        topic = dds_topic(Role.TOPIC, endpoint.name, verbatim=verbatim)
        data = encode_endpoint(EndpointData(endpoint.type_hash))
        with endpoint_qos(context.library, endpoint.qos, data, ignore_local=endpoint.ignore_local) as qos:
            reader = Reader(context.participant, topic, dds_type(Role.TOPIC, endpoint.type_name), qos)
        new.undo.append(reader.delete)
        new.undo.append(partial(context.statuses.discard, reader.handle))
        super().__init__(new.state, reader.guid)
        self.reader = reader
        self._context = context
        self._known = context.peers.known
        self._deliver = deliver
        self._dispatcher = ReaderDispatcher(reader, new.state.title, self._on_message)
        new.take_in(topic, self._dispatcher)

    def _on_message(self, message: RawSample) -> None:
        payload, sent, publication = message
        peer = self._known.get(publication) or self._context.peers.publication(
            self.reader.handle, publication
        )
        gid = publication.to_bytes(16, 'little') if peer is None else peer.gid
        self._deliver(new_sample((payload, NOT_COUNTED, sent, time_ns(), gid)))

    def catch_up(self) -> None:
        """Deliver the messages that are in the reader. The library serves its readers in no fixed order."""
        self._dispatcher.drain_own()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Call `changed` with an event's totals; False if the library does not report this event."""
        return self._context.statuses.watch_event(self.reader.handle, event, changed)

    def peer_count(self) -> int:
        """Return how many endpoints the library has matched with this endpoint."""
        context = self._context
        return context.statuses.peers_of(self.reader.handle, SUBSCRIPTION_MATCHED, context.notifier.connected)
