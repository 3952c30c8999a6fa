"""Publishers and subscriptions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import time_ns

from goalwire.errors import TransportError
from goalwire.rtps.protocol.announcements import EndpointData as RtpsEndpoint
from goalwire.rtps.protocol.reader import ReaderListener
from goalwire.rtps.protocol.reader import Sample as RtpsSample
from goalwire.rtps.protocol.writer import WriterListener
from goalwire.rules.qos_events import EventStatus, EventType, PublisherEvent, SubscriptionEvent
from goalwire.transport.contract import Endpoint, Sample, new_sample
from goalwire.transport.dds.description import (
    GUID_PREFIX_SIZE,
    EndpointData,
    Role,
    dds_topic,
    dds_type,
    encode_endpoint,
)
from goalwire.transport.dds.native.context import NativeContext
from goalwire.transport.dds.native.events import EventTotals
from goalwire.transport.dds.native.qos import reader_qos, writer_qos
from goalwire.transport.dds.session import PublisherEnd
from goalwire.transport.endpoint import EndpointState, OpenPort

NOT_COUNTED = 0
"""The sequence number of every message: DDS does not provide it."""


def _names(endpoint: Endpoint) -> tuple[str, str]:
    """Return the names that the endpoint's topic and type have on DDS."""
    topic = dds_topic(Role.TOPIC, endpoint.name, verbatim=endpoint.qos.avoid_ros_namespace_conventions)
    return topic, dds_type(Role.TOPIC, endpoint.type_name)


class _WriterEvents(WriterListener):
    """Counts the events of a publisher's writer."""

    def __init__(self, totals: EventTotals, on_change: Callable[[], None]) -> None:
        self._totals = totals
        self._on_change = on_change
        self.on_deadline_missed = totals.count_offered_deadline  # type: ignore[method-assign]
        self.on_liveliness_lost = totals.count_liveliness_lost  # type: ignore[method-assign]

    def on_matched(self, reader: RtpsEndpoint) -> None:  # noqa: ARG002
        self._totals.count_match(PublisherEvent.RCL_PUBLISHER_MATCHED, 1)
        self._on_change()

    def on_unmatched(self, reader: RtpsEndpoint) -> None:  # noqa: ARG002
        self._totals.count_match(PublisherEvent.RCL_PUBLISHER_MATCHED, -1)
        self._on_change()

    def on_incompatible(self, reader: RtpsEndpoint, policy: str) -> None:  # noqa: ARG002
        self._totals.count_incompatible(PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS, policy)


class NativePublisher(PublisherEnd):
    """A declared publisher."""

    def __init__(self, context: NativeContext, state: EndpointState, endpoint: Endpoint) -> None:
        self._context = context
        self._totals = EventTotals()
        self._is_counted = False
        data = encode_endpoint(EndpointData(endpoint.type_hash))
        qos = writer_qos(endpoint.qos, context.defaults)
        listener = _WriterEvents(self._totals, self._on_change)
        writer = context.participant.create_writer(*_names(endpoint), qos, listener, data)
        state.undo.append(partial(context.participant.delete, writer))
        super().__init__(state, writer.data.guid)
        self._writer = writer
        self._write = context.rtps.write

    def publish(self, payload: bytes) -> None:
        """Write one message. If several threads publish at once, the order of their messages is undefined."""
        state = self.state
        if state.closed or state.guard.is_silent:
            state.check_sending()
        if self._write(self._writer, payload) is None:
            state.check()  # another thread may have closed the publisher in the meantime
            raise TransportError(
                f'{state.title}: a message was not sent, since subscriptions have not acknowledged earlier '
                f'ones in time; publish less often, or keep the last messages only'
            )

    def _on_change(self) -> None:
        if self._is_counted:
            self._context.notifier.connected()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Call `changed` with an event's totals; False if RTPS does not report this event."""
        return self._totals.watch(event, changed)

    def peer_count(self) -> int:
        """How many subscriptions are matched with this publisher."""
        self._is_counted = True
        return len(self._writer.readers)

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive, if its QoS leaves that to the user."""
        self.state.check_sending()
        self._writer.assert_liveliness()

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait until every reliable reader has received all messages; False if that takes too long."""
        self.state.check()
        timeout_s = float('inf') if timeout_ns is None else timeout_ns / 1e9
        return self._context.rtps.wait_for_acknowledgements(self._writer.is_acknowledged_by_all, timeout_s)


class NativeSubscription(OpenPort, ReaderListener):
    """A declared subscription."""

    def __init__(
        self,
        context: NativeContext,
        state: EndpointState,
        endpoint: Endpoint,
        deliver: Callable[[Sample], None],
    ) -> None:
        self._context = context
        self._totals = EventTotals()
        self._is_counted = False
        self._silent: set[bytes] = set()
        """The publishers that have failed to show that they are alive."""
        self._deliver = deliver
        self._ignored = context.participant.prefix if endpoint.ignore_local else b''
        self.on_lost = self._totals.count_lost  # type: ignore[method-assign]
        self.on_deadline_missed = self._totals.count_requested_deadline  # type: ignore[method-assign]
        self.state = state
        data = encode_endpoint(EndpointData(endpoint.type_hash))
        qos = reader_qos(endpoint.qos, context.defaults)
        reader = context.participant.create_reader(*_names(endpoint), qos, self, data)
        state.undo.append(partial(context.participant.delete, reader))
        super().__init__(state, reader.data.guid)
        self._reader = reader

    def on_sample(self, sample: RtpsSample) -> None:
        payload, gid, now = sample.payload, sample.writer, time_ns()
        if payload is None or self.state.closed:
            return
        if self._ignored and gid[:GUID_PREFIX_SIZE] == self._ignored:
            return
        self._deliver(new_sample((payload, NOT_COUNTED, sample.time or now, now, gid)))

    def on_matched(self, writer: RtpsEndpoint) -> None:  # noqa: ARG002
        self._totals.count_match(SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED, 1)
        self._totals.count_alive(1, 0)
        self._on_change()

    def on_unmatched(self, writer: RtpsEndpoint) -> None:
        self._totals.count_match(SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED, -1)
        if writer.guid in self._silent:
            self._silent.discard(writer.guid)
            self._totals.count_alive(0, -1)
        else:
            self._totals.count_alive(-1, 0)
        self._on_change()

    def on_incompatible(self, writer: RtpsEndpoint, policy: str) -> None:  # noqa: ARG002
        self._totals.count_incompatible(SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS, policy)

    def on_liveliness(self, writer: bytes, is_alive: bool) -> None:
        if is_alive:
            self._silent.discard(writer)
            self._totals.count_alive(1, -1)
        else:
            self._silent.add(writer)
            self._totals.count_alive(-1, 1)

    def _on_change(self) -> None:
        if self._is_counted:
            self._context.notifier.connected()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Call `changed` with an event's totals; False if RTPS does not report this event."""
        return self._totals.watch(event, changed)

    def peer_count(self) -> int:
        """How many publishers are matched with this subscription."""
        self._is_counted = True
        return len(self._reader.writers)
