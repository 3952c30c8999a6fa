"""Events that the library itself reports for an endpoint: matches, deadlines, liveliness, lost messages."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import byref, c_uint32, c_uint64
from threading import Lock
from typing import NamedTuple, TypeAlias

from goalwire.errors import TransportError
from goalwire.rules.qos import PolicyKind
from goalwire.rules.qos_events import (
    NOTHING_YET,
    EventStatus,
    EventType,
    IncompatibleQoS,
    LivelinessChanged,
    LivelinessLost,
    Matched,
    MessageLost,
    OfferedDeadlineMissed,
    PublisherEvent,
    RequestedDeadlineMissed,
    SubscriptionEvent,
)
from goalwire.transport.dds.cyclone.abi import AliveCounts, BuiltinEndpoint, Counts, Function, Library
from goalwire.transport.dds.cyclone.qos import read_user_data
from goalwire.transport.dds.cyclone.waitset import WaitsetThread
from goalwire.transport.dds.description import GUID_PREFIX_SIZE, EndpointData, decode_endpoint

_CACHE_LIMIT = 1000
"""How many handles are kept, also of endpoints that have gone. At this number the cache is emptied."""
_FAST_DDS = b'\x01\x0f'


class Peer(NamedTuple):
    """A matched endpoint."""

    handle: int
    """The library's number of the endpoint."""
    gid: bytes
    service_id: str
    client_id: str
    takes_refusals: bool
    speaks_fast_dds: bool
    """True if the peer's implementation is Fast DDS, whose services have no header."""
    server: str
    """The id by which the reader and the writer of one server are known to belong together."""


def _peer(handle: int, gid: bytes, data: EndpointData) -> Peer:
    return Peer(
        handle,
        gid,
        data.service_id,
        data.client_id,
        data.takes_refusals,
        gid[:2] == _FAST_DDS,
        data.service_id or gid[:GUID_PREFIX_SIZE].hex(),
    )


class Peers:
    """A cache of matched endpoints by handle. The library never gives a handle to another endpoint."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self.known: dict[int, Peer] = {}
        """The cached endpoints by handle; looked up here for each message, before the library is asked."""

    def publication(self, reader: int, handle: int) -> Peer | None:
        """Return the writer that a reader is matched with; None if it has gone."""
        return self.known.get(handle) or self._ask(
            self._library.dds_get_matched_publication_data, reader, handle
        )

    def is_matched(self, reader: int, handle: int) -> bool:
        """Return whether a reader is matched with a writer now."""
        address = self._library.dds_get_matched_publication_data(reader, handle)
        if address:
            self._library.dds_builtintopic_free_endpoint(address)
        return bool(address)

    def publications(self, reader: int) -> list[Peer]:
        """Return every writer that a reader is matched with."""
        handles = _handles(self._library.dds_get_matched_publications, reader)
        return [peer for handle in handles if (peer := self.publication(reader, handle)) is not None]

    def subscriptions(self, writer: int) -> list[Peer]:
        """Return every reader that a writer is matched with."""
        ask = self._library.dds_get_matched_subscription_data
        handles = _handles(self._library.dds_get_matched_subscriptions, writer)
        found = (self.known.get(handle) or self._ask(ask, writer, handle) for handle in handles)
        return [peer for peer in found if peer is not None]

    def _ask(self, function: Function, entity: int, handle: int) -> Peer | None:
        address = function(entity, handle)
        if not address:
            return None
        try:
            endpoint = ctypes.cast(address, ctypes.POINTER(BuiltinEndpoint)).contents
            told = decode_endpoint(read_user_data(self._library, endpoint.qos))
            peer = _peer(handle, bytes(endpoint.key), told)
        finally:
            self._library.dds_builtintopic_free_endpoint(address)
        if len(self.known) >= _CACHE_LIMIT:
            self.known.clear()
        self.known[handle] = peer
        return peer


def _handles(function: Function, entity: int) -> list[int]:
    room = 16
    while True:
        handles = (c_uint64 * room)()
        count = function(entity, handles, room)
        if count <= room:
            return list(handles[: max(count, 0)])
        room = 2 * count


PUBLICATION_MATCHED = 1 << 11
SUBSCRIPTION_MATCHED = 1 << 12

Changed: TypeAlias = Callable[[EventStatus], None]

_POLICIES = {
    2: PolicyKind.RMW_QOS_POLICY_DURABILITY,
    4: PolicyKind.RMW_QOS_POLICY_DEADLINE,
    8: PolicyKind.RMW_QOS_POLICY_LIVELINESS,
    11: PolicyKind.RMW_QOS_POLICY_RELIABILITY,
    13: PolicyKind.RMW_QOS_POLICY_HISTORY,
    21: PolicyKind.RMW_QOS_POLICY_LIFESPAN,
}
"""DDS's numbers of the policies that ROS 2 has (dds_public_status.h)."""


class _Source(NamedTuple):
    """The source of an event's record: the status's name and bit, and the function that makes the record."""

    name: str
    bit: int
    record: Callable[[Counts], EventStatus] | None = None


def _policy(counts: Counts) -> IncompatibleQoS:
    kind = _POLICIES.get(counts.extra[0], PolicyKind.RMW_QOS_POLICY_INVALID)
    return IncompatibleQoS(counts.total, 0, kind)


def _read_matched(counts: Counts) -> Matched:
    return Matched(counts.total, 0, counts.extra[0], 0)


_SOURCES: dict[EventType, _Source] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED: _Source(
        'offered_deadline_missed', 1 << 1, lambda counts: OfferedDeadlineMissed(counts.total)
    ),
    PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST: _Source(
        'liveliness_lost', 1 << 9, lambda counts: LivelinessLost(counts.total)
    ),
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: _Source(
        'offered_incompatible_qos', 1 << 3, _policy
    ),
    PublisherEvent.RCL_PUBLISHER_MATCHED: _Source('publication_matched', PUBLICATION_MATCHED, _read_matched),
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED: _Source(
        'requested_deadline_missed', 1 << 2, lambda counts: RequestedDeadlineMissed(counts.total)
    ),
    SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED: _Source('liveliness_changed', 1 << 10),
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: _Source(
        'requested_incompatible_qos', 1 << 4, _policy
    ),
    SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST: _Source(
        'sample_lost', 1 << 5, lambda counts: MessageLost(counts.total)
    ),
    SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED: _Source(
        'subscription_matched', SUBSCRIPTION_MATCHED, _read_matched
    ),
}
"""The source of each event; incompatible types are found in the graph, as the library reports none."""


class Statuses:
    """Calls the listeners of an entity's statuses, on the discovery thread."""

    def __init__(self, library: Library, waitset_thread: WaitsetThread) -> None:
        self._library = library
        self._waitset_thread = waitset_thread
        self._lock = Lock()
        self._handlers: dict[int, dict[int, tuple[Callable[[], None], ...]]] = {}

    def watch(self, entity: int, bit: int, handler: Callable[[], None]) -> None:
        """Call `handler` each time the status changes. A handler that is known already is ignored."""
        with self._lock:
            known = self._handlers.get(entity, {})
            others = known.get(bit, ())
            if handler in others:
                return
            handlers = self._handlers[entity] = {**known, bit: (*others, handler)}
            self._library.dds_set_status_mask(entity, sum(handlers))
        if not known:
            try:
                self._waitset_thread.watch(entity, lambda: self._on_change(entity))
            except TransportError:
                self.discard(entity)
                raise

    def peers_of(self, entity: int, bit: int, handler: Callable[[], None]) -> int:
        """Count an endpoint's matches, and call `handler` each time they change from now on.

        The matched endpoints are counted, since reading the status would reset it, and other handlers would
        miss the change.
        """
        try:
            self.watch(entity, bit, handler)
        except TransportError:
            return 0  # another thread has just deleted the entity
        library = self._library
        writes = bit == PUBLICATION_MATCHED
        count = library.dds_get_matched_subscriptions if writes else library.dds_get_matched_publications
        return max(count(entity, None, 0), 0)

    def watch_event(self, entity: int, event: EventType, changed: Changed) -> bool:
        """Call `changed` with an event's totals; False if the library does not report this event."""
        source = _SOURCES.get(event)
        if source is None:
            return False

        last = NOTHING_YET[event]
        lock = Lock()

        def tell() -> None:
            nonlocal last
            with lock:  # several threads may tell: the newest record must be reported last
                record = self._record(entity, source)
                if record is not None and record != last:
                    last = record
                    changed(record)

        self.watch(entity, source.bit, tell)
        # Earlier events are reported now. Reading a status resets it, so all its handlers are called.
        self._call(entity, source.bit)
        return True

    def discard(self, entity: int) -> None:
        """Forget an entity that is about to be deleted."""
        with self._lock:
            known = self._handlers.pop(entity, None)
        if known is not None:
            self._waitset_thread.unwatch(entity)

    def reset(self, entity: int, bits: int) -> None:
        """Mark the changes as seen, so that the next wait sleeps until there are new ones."""
        self._library.dds_take_status(entity, byref(c_uint32()), bits)

    def _on_change(self, entity: int) -> None:
        handlers = self._handlers.get(entity, {})
        changes = c_uint32()
        self._library.dds_take_status(entity, byref(changes), sum(handlers))
        for bit in handlers:
            if changes.value & bit:
                self._call(entity, bit)

    def _call(self, entity: int, bit: int) -> None:
        for handler in self._handlers.get(entity, {}).get(bit, ()):
            handler()

    def _record(self, entity: int, source: _Source) -> EventStatus | None:
        read = self._library.status(source.name)
        if source.record is None:
            alive = AliveCounts()
            if read(entity, byref(alive)) < 0:
                return None
            return LivelinessChanged(alive.alive, 0, alive.not_alive, 0)
        counts = Counts()
        return None if read(entity, byref(counts)) < 0 else source.record(counts)
