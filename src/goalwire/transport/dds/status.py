"""What the library itself notices of an endpoint: matches, deadlines, liveliness, losses."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_uint32
from threading import Lock
from typing import NamedTuple, TypeAlias

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
from goalwire.transport.dds.abi import AliveCounts, Counts, Library
from goalwire.transport.dds.waitset_thread import WaitsetThread

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
"""DDS's numbers of policies, those that ROS 2 has (dds_public_status.h)."""


class _Source(NamedTuple):
    """Where an event's record comes from: the status's name and bit, and what makes the record."""

    name: str
    bit: int
    record: Callable[[Counts], EventStatus] | None = None


def _policy(counts: Counts) -> IncompatibleQoS:
    kind = _POLICIES.get(counts.extra[0], PolicyKind.RMW_QOS_POLICY_INVALID)
    return IncompatibleQoS(counts.total, 0, kind)


def _matched(counts: Counts) -> Matched:
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
    PublisherEvent.RCL_PUBLISHER_MATCHED: _Source('publication_matched', PUBLICATION_MATCHED, _matched),
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
        'subscription_matched', SUBSCRIPTION_MATCHED, _matched
    ),
}
"""What the library does not tell, a type that does not fit, is found in the graph."""


class Statuses:
    """Calls who wants to know of an entity's statuses, on the discovery thread."""

    def __init__(self, library: Library, waitset_thread: WaitsetThread) -> None:
        self._library = library
        self._waitset_thread = waitset_thread
        self._lock = Lock()
        self._handlers: dict[int, dict[int, Callable[[], None]]] = {}

    def watch(self, entity: int, bit: int, handler: Callable[[], None]) -> None:
        """Call `handler` each time the status changes; it must look at it (or have it taken)."""
        with self._lock:
            first = entity not in self._handlers
            handlers = self._handlers[entity] = {**self._handlers.get(entity, {}), bit: handler}
            self._library.dds_set_status_mask(entity, sum(handlers))
        if first:
            self._waitset_thread.watch(entity, lambda: self._changed(entity))

    def watch_event(self, entity: int, event: EventType, changed: Changed) -> bool:
        """Tell `changed` of an event with its totals; False where the library does not notice it."""
        source = _SOURCES.get(event)
        if source is None:
            return False

        last = NOTHING_YET[event]

        def tell() -> None:
            nonlocal last
            record = self._record(entity, source)
            if record is not None and record != last:
                last = record
                changed(record)

        self.watch(entity, source.bit, tell)
        tell()  # what happened before
        return True

    def discard(self, entity: int) -> None:
        """The entity is about to go."""
        with self._lock:
            known = self._handlers.pop(entity, None)
        if known is not None:
            self._waitset_thread.unwatch(entity)

    def reset(self, entity: int, bits: int) -> None:
        """Take note of changes: waiting for the next ones sleeps again."""
        self._library.dds_take_status(entity, byref(c_uint32()), bits)

    def _changed(self, entity: int) -> None:
        handlers = self._handlers.get(entity, {})
        changes = c_uint32()
        self._library.dds_take_status(entity, byref(changes), sum(handlers))
        for bit, handler in handlers.items():
            if changes.value & bit:
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
