"""The events of a publisher or subscription: their sources, and how they reach a callback.

If the wire itself reports a kind of event, it comes from the endpoint's port (`Port.watch_event`). Else the
graph tells which endpoints match and which cannot, and the numbers of messages tell how many were lost. Other
kinds are refused, as rmw_zenoh refuses deadlines and liveliness: a callback that never comes would be worse.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from goalwire.errors import InvalidHandle, UnsupportedEventTypeError
from goalwire.execution.ready_queue import CallbackSource
from goalwire.execution.weak_methods import weakly
from goalwire.logging import get_logger
from goalwire.places import at
from goalwire.rules.qos_compatibility import incompatible_policy
from goalwire.rules.qos_events import (
    NOTHING_YET,
    EventStatus,
    EventType,
    IncompatibleQoS,
    PublisherEvent,
    SequenceGaps,
    SubscriptionEvent,
    changes_between,
    incompatible_qos_warning,
    with_fields,
)
from goalwire.transport import registry
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.entities.node import NodeCore
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.graph.watch import CounterpartWatch
    from goalwire.rules.qos import PolicyKind
    from goalwire.transport.contract import Endpoint, GraphEntity, Port, Sample


class _FromGraph(NamedTuple):
    """The events that an endpoint gets from the graph."""

    matched: EventType
    incompatible_qos: EventType
    incompatible_type: EventType


_FROM_GRAPH = {
    EndpointKind.PUBLISHER: _FromGraph(
        PublisherEvent.RCL_PUBLISHER_MATCHED,
        PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
    ),
    EndpointKind.SUBSCRIPTION: _FromGraph(
        SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED,
        SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
        SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
    ),
}


class EndpointEvents:
    """Counts the events of one endpoint, each from its first reader on, and tells the readers."""

    def __init__(
        self,
        node: NodeCore,
        endpoint: Endpoint,
        port: Port,
        watch_arrivals: Callable[[Callable[[Sample], None]], None] | None = None,
    ) -> None:
        """`watch_arrivals`, of a subscription, takes a function that its transport's threads call with each
        message.
        """
        self.node = node
        self.endpoint = endpoint
        session = node.context.session
        self._enforces_qos = session.enforces_qos
        self._compares_definitions = session.compares_definitions
        self._port = port
        self._watch_arrivals = watch_arrivals
        self.lock = Lock()
        """Guards the totals, and what each reader has seen of them."""
        self._status: dict[EventType, EventStatus] = {}
        self._started: set[EventType] = set()
        self._told_by_wire: set[EventType] = set()
        self._readers: tuple[EventReader, ...] = ()
        self._matched: set[bytes] = set()
        self._watch: CounterpartWatch | None = None
        self._watches_graph = False
        self._gaps = SequenceGaps()
        self._closed = False

    def reader(
        self, event: EventType, group: CallbackGroup | None, callback: Callable[[Any], object]
    ) -> EventReader:
        """Have `callback` called with each change of an event, by the node's executor.

        Raises UnsupportedEventTypeError if this wire cannot tell, TypeError for an event of the other kind
        of endpoint, InvalidHandle once the endpoint is destroyed.
        """
        if self._closed:
            raise InvalidHandle
        kind = self.endpoint.kind
        known = PublisherEvent if kind is EndpointKind.PUBLISHER else SubscriptionEvent
        if not isinstance(event, known):
            choice = ', '.join(each.name for each in known)
            raise TypeError(f'a {kind.value} has no event {event!r}: choose one of {choice}')
        reader = EventReader(self, event, group, callback)
        with self.lock:
            self._readers += (reader,)
        try:
            self._start(event)
        except BaseException:
            self.discard(reader)
            raise
        if reader.events:
            reader.notify()  # the event has happened before this reader came
        return reader

    def discard(self, reader: EventReader) -> None:
        """Remove a reader."""
        with self.lock:
            self._readers = tuple(each for each in self._readers if each is not reader)

    def status(self, event: EventType) -> EventStatus:
        """Return the totals of an event."""
        return self._status.get(event) or NOTHING_YET[event]

    @property
    def wire_that_delivers_all_the_same(self) -> str | None:
        """The wire's name, if messages flow there in spite of incompatible QoS."""
        return None if self._enforces_qos else registry.select_identifier()

    def close(self) -> None:
        """Stop counting: the endpoint ends. Idempotent."""
        self._closed = True
        if self._watch is not None:
            self.node.remains.discard(self._watch.close)
            self._watch.close()
        for reader in self._readers:
            reader.close()

    def _start(self, event: EventType) -> None:
        """Begin to count an event."""
        with self.lock:
            if event in self._started:
                return
            self._started.add(event)
        if self._port.watch_event(event, partial(weakly(self._set), event)):
            self._told_by_wire.add(event)
            return
        if self._watch_arrivals is not None and event is SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST:
            self._watch_arrivals(weakly(self._note_arrival))
        elif event not in _FROM_GRAPH[self.endpoint.kind]:
            self._started.discard(event)
            raise UnsupportedEventTypeError(event.name, self.endpoint.name, registry.select_identifier())
        self._watch_graph()

    # -- from the wire and the messages --------------------------------------------------------------------

    def _set(self, event: EventType, status: EventStatus) -> None:
        with self.lock:
            self._status[event] = status
        self._notify(event)

    def _note_arrival(self, sample: Sample) -> None:
        """Count the messages before this one that never came; on the transport's thread."""
        with self.lock:
            missed = self._gaps.count_missed(sample.gid, sample.sequence)
        if missed:
            self._add(SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST, total_count=missed)

    # -- from the graph ------------------------------------------------------------------------------------

    def _watch_graph(self) -> None:
        with self.lock:
            first, self._watches_graph = not self._watches_graph, True
        if first:  # outside the lock: `_on_counterpart` is called at once, and locks
            own = self.endpoint
            self._watch = self.node.graph.watch_counterparts(own.kind, own.name, weakly(self._on_counterpart))
            self.node.remains.add(self._watch.close)
            if self._closed:  # another thread called `close` before there was a watch
                self._watch.close()

    def _on_counterpart(self, peer: GraphEntity, is_there: bool) -> None:
        if is_there:
            self._meet(peer)
            return
        with self.lock:
            self._gaps.discard(peer.gid)
        if peer.gid in self._matched:
            self._matched.discard(peer.gid)
            self._add(_FROM_GRAPH[self.endpoint.kind].matched, current_count=-1)

    def _meet(self, peer: GraphEntity) -> None:
        own = self.endpoint
        events = _FROM_GRAPH[own.kind]
        known_hashes = {peer.type_hash, own.type_hash} - {''}  # some peers announce no hash
        differs = len(known_hashes) > 1 and self._compares_definitions
        if peer.type_name != own.type_name or differs:
            self._add(events.incompatible_type, total_count=1)
            return
        offers, asks = (own, peer) if own.kind is EndpointKind.PUBLISHER else (peer, own)
        policy = incompatible_policy(offers.qos, asks.qos)
        if policy is not None:
            self._add(events.incompatible_qos, policy, total_count=1)
        if policy is None or not self._enforces_qos:
            self._matched.add(peer.gid)
            self._add(events.matched, total_count=1, current_count=1)

    def _add(self, event: EventType, policy: PolicyKind | None = None, **counts: int) -> None:
        if event in self._told_by_wire:
            return
        with self.lock:
            status = self.status(event)
            changed = {name: getattr(status, name) + number for name, number in counts.items()}
            if policy is not None:
                changed['last_policy_kind'] = policy
            self._status[event] = with_fields(status, **changed)
        self._notify(event)

    def _notify(self, event: EventType) -> None:
        for reader in self._readers:
            if reader.event is event:
                reader.notify()


class EventReader(CallbackSource):
    """One callback, and the totals it has seen. Several changes that come before the callback runs make one
    call.
    """

    __slots__ = ('_posted', '_seen', '_source', 'callback', 'closed', 'event', 'watchers')

    counts_up = False

    def __init__(
        self,
        source: EndpointEvents,
        event: EventType,
        group: CallbackGroup | None,
        callback: Callable[[Any], object],
    ) -> None:
        super().__init__(source.node.work_queue, group)
        self.event = event
        self.callback = callback
        self.closed = False
        self.watchers: Sequence[Callable[[], None]] = ()
        self._source = source
        self._posted = False
        self._seen: EventStatus = NOTHING_YET[event]

    @property
    def events(self) -> int:
        """1 if there is something to take, else 0; see waitable.Waited."""
        return int(not self.closed and self._source.status(self.event) is not self._seen)

    def notify(self) -> None:
        """Have the executor call back. Any thread may call this."""
        if not self._posted and not self.closed:
            self._posted = True
            self.work_queue.post(self)
        for wake in self.watchers:
            wake()

    def take(self) -> EventStatus | None:
        """Return the record with the changes since it was last taken; None if there are none."""
        source = self._source
        with source.lock:  # another thread may be in here, too, if the callback group allows that
            earlier, status = self._seen, source.status(self.event)
            if self.closed or status is earlier:
                return None
            self._seen = status
        return changes_between(earlier, status)

    def run(self) -> object:
        self._posted = False
        changes = self.take()
        return None if changes is None else self.callback(changes)

    def close(self) -> None:
        """Stop calling back. Idempotent."""
        self.closed = True
        self._source.discard(self)


class TopicEndpoint(Protocol):
    """A publisher or subscription."""

    node: NodeCore

    @property
    def events(self) -> EndpointEvents:
        """The source of the endpoint's events."""


def default_callback(endpoint: TopicEndpoint, event: EventType, topic: str) -> Callable[[Any], object] | None:
    """Return a callback that warns of an event, with the topic's name as given; None for other events."""
    warn = _WARNINGS.get(event)
    return None if warn is None else partial(warn, endpoint, event, topic)


def warn_by_default(endpoint: TopicEndpoint, topic: str) -> None:
    """Have default callbacks warn of all events that have one, as far as this wire reports them."""
    publishes = endpoint.events.endpoint.kind is EndpointKind.PUBLISHER
    for event in _WARNINGS:
        if isinstance(event, PublisherEvent) is publishes:
            callback = default_callback(endpoint, event, topic)
            assert callback is not None
            with suppress(UnsupportedEventTypeError):
                endpoint.events.reader(event, None, callback)


def _warn_of_qos(endpoint: TopicEndpoint, event: EventType, topic: str, status: IncompatibleQoS) -> None:
    wire = endpoint.events.wire_that_delivers_all_the_same
    text = incompatible_qos_warning(event, topic, status.last_policy_kind, wire=wire)
    own = endpoint.events.endpoint
    place = endpoint.node.context.endpoint_places.find(own.kind, own.name)
    get_logger(endpoint.node.logger_name).warning(f'{text}{at(place)}')


def _leave_to_graph(*_: object) -> None:
    """A different type is left to the graph: it warns once for both sides, of services and actions too."""


_WARNINGS: dict[EventType, Callable[..., None]] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: _warn_of_qos,
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: _warn_of_qos,
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE: _leave_to_graph,
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: _leave_to_graph,
}
