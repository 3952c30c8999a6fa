"""Totals of the events of an RTPS writer or reader, as the records of ROS 2's events."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from typing import TypeAlias

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

Changed: TypeAlias = Callable[[EventStatus], None]

_POLICIES = {
    'durability': PolicyKind.RMW_QOS_POLICY_DURABILITY,
    'deadline': PolicyKind.RMW_QOS_POLICY_DEADLINE,
    'liveliness': PolicyKind.RMW_QOS_POLICY_LIVELINESS,
    'reliability': PolicyKind.RMW_QOS_POLICY_RELIABILITY,
}
_ELSEWHERE = {
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE,
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
}
"""Events that RTPS does not report. Incompatible types are found in the graph instead."""


class EventTotals:
    """The records of one endpoint's events, and the functions that are called when they change."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._records: dict[EventType, EventStatus] = {}
        self._watchers: dict[EventType, Changed] = {}

    def watch(self, event: EventType, changed: Changed) -> bool:
        """Call `changed` at each event, and now if one has happened; False if RTPS does not report it."""
        if event in _ELSEWHERE:
            return False
        with self._lock:
            self._watchers[event] = changed
            record = self._records.get(event)
        if record is not None:
            changed(record)
        return True

    def _count(self, event: EventType, add: Callable[[EventStatus], EventStatus]) -> None:
        with self._lock:
            record = self._records[event] = add(self._records.get(event, NOTHING_YET[event]))
            changed = self._watchers.get(event)
        if changed is not None:
            changed(record)

    def count_match(self, event: EventType, change: int) -> None:
        """Count a matched endpoint that has come (1) or gone (-1)."""

        def add(record: EventStatus) -> Matched:
            assert isinstance(record, Matched)
            return Matched(record.total_count + max(change, 0), 0, record.current_count + change, 0)

        self._count(event, add)

    def count_incompatible(self, event: EventType, policy: str) -> None:
        """Count an endpoint that was not matched because of a QoS policy."""
        kind = _POLICIES.get(policy, PolicyKind.RMW_QOS_POLICY_INVALID)

        def add(record: EventStatus) -> IncompatibleQoS:
            assert isinstance(record, IncompatibleQoS)
            return IncompatibleQoS(record.total_count + 1, 0, kind)

        self._count(event, add)

    def count_lost(self, count: int) -> None:
        """Count messages that will not arrive."""

        def add(record: EventStatus) -> MessageLost:
            assert isinstance(record, MessageLost)
            return MessageLost(record.total_count + count)

        self._count(SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST, add)

    def count_offered_deadline(self) -> None:
        """Count a deadline that this publisher missed."""

        def add(record: EventStatus) -> OfferedDeadlineMissed:
            assert isinstance(record, OfferedDeadlineMissed)
            return OfferedDeadlineMissed(record.total_count + 1)

        self._count(PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED, add)

    def count_requested_deadline(self) -> None:
        """Count a message that did not arrive by its deadline."""

        def add(record: EventStatus) -> RequestedDeadlineMissed:
            assert isinstance(record, RequestedDeadlineMissed)
            return RequestedDeadlineMissed(record.total_count + 1)

        self._count(SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED, add)

    def count_liveliness_lost(self) -> None:
        """Count that this publisher has failed to show that it is alive."""

        def add(record: EventStatus) -> LivelinessLost:
            assert isinstance(record, LivelinessLost)
            return LivelinessLost(record.total_count + 1)

        self._count(PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST, add)

    def count_alive(self, alive: int, not_alive: int) -> None:
        """Change how many publishers are alive and not alive, by the given differences."""

        def add(record: EventStatus) -> LivelinessChanged:
            assert isinstance(record, LivelinessChanged)
            return LivelinessChanged(record.alive_count + alive, 0, record.not_alive_count + not_alive, 0)

        self._count(SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED, add)
