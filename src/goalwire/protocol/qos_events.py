"""What a publisher or subscription can tell beside messages: kinds of events and their status records.

Names and numbers are those of rcl/event.h (rcl_publisher_event_type_t, rcl_subscription_event_type_t), the
records those of rmw/events_statuses. A source of events keeps totals; what changed since somebody last looked
is the difference of two records, `changed_since`, so that any number of readers share one source.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, Self, TypeAlias

from goalwire.protocol.qos import PolicyKind


class _EventType(Enum):
    """A kind of event; int() gives rcl's number."""

    def __int__(self) -> int:
        number: int = self.value
        return number


class PublisherEvent(_EventType):
    """What a publisher can tell."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class SubscriptionEvent(_EventType):
    """What a subscription can tell."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


EventType: TypeAlias = PublisherEvent | SubscriptionEvent


class _Count(NamedTuple):
    total_count: int = 0
    total_count_change: int = 0

    def changed_since(self, earlier: Self) -> Self:
        """This record with the changes since an earlier one."""
        return self._replace(total_count_change=self.total_count - earlier.total_count)


class OfferedDeadlineMissed(_Count):
    """How often a publisher was later than it had promised."""

    __slots__ = ()


class RequestedDeadlineMissed(_Count):
    """How often a message came later than asked for."""

    __slots__ = ()


class LivelinessLost(_Count):
    """How often a publisher failed to show that it is alive."""

    __slots__ = ()


class MessageLost(_Count):
    """How many messages did not arrive."""

    __slots__ = ()


class IncompatibleType(_Count):
    """How many endpoints of another type were met under the same name."""

    __slots__ = ()


class LivelinessChanged(NamedTuple):
    """How many publishers are alive, and how many are not any more."""

    alive_count: int = 0
    not_alive_count: int = 0
    alive_count_change: int = 0
    not_alive_count_change: int = 0

    def changed_since(self, earlier: Self) -> Self:
        """This record with the changes since an earlier one."""
        return self._replace(
            alive_count_change=self.alive_count - earlier.alive_count,
            not_alive_count_change=self.not_alive_count - earlier.not_alive_count,
        )


class Matched(NamedTuple):
    """How many counterparts there have been, and how many there are."""

    total_count: int = 0
    total_count_change: int = 0
    current_count: int = 0
    current_count_change: int = 0

    def changed_since(self, earlier: Self) -> Self:
        """This record with the changes since an earlier one."""
        return self._replace(
            total_count_change=self.total_count - earlier.total_count,
            current_count_change=self.current_count - earlier.current_count,
        )


class IncompatibleQoS(NamedTuple):
    """How many counterparts had a QoS that does not go together, and for which policy the last one."""

    total_count: int = 0
    total_count_change: int = 0
    last_policy_kind: PolicyKind = PolicyKind.RMW_QOS_POLICY_INVALID

    def changed_since(self, earlier: Self) -> Self:
        """This record with the changes since an earlier one."""
        return self._replace(total_count_change=self.total_count - earlier.total_count)


EventStatus: TypeAlias = _Count | LivelinessChanged | Matched | IncompatibleQoS

STATUS: dict[EventType, type[EventStatus]] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED: OfferedDeadlineMissed,
    PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST: LivelinessLost,
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: IncompatibleQoS,
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE: IncompatibleType,
    PublisherEvent.RCL_PUBLISHER_MATCHED: Matched,
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED: RequestedDeadlineMissed,
    SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED: LivelinessChanged,
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: IncompatibleQoS,
    SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST: MessageLost,
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: IncompatibleType,
    SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED: Matched,
}
"""The record of each kind of event; without arguments it says that nothing has happened yet."""


def incompatible_qos_warning(event: EventType, topic: str, policy: PolicyKind, *, wire: str | None) -> str:
    """Return ROS 2's words for an endpoint whose QoS does not go together with ours.

    `wire` names one that delivers all the same: then they would not be true alone.
    """
    if isinstance(event, PublisherEvent):
        found = f"New subscription discovered on topic '{topic}', requesting incompatible QoS. "
        consequence = 'No messages will be sent to it. '
    else:
        found = f"New publisher discovered on topic '{topic}', offering incompatible QoS. "
        consequence = 'No messages will be received from it. '
    reason = f'Last incompatible policy: {policy.name.removeprefix("RMW_QOS_POLICY_")}'
    note = '' if wire is None else f' (that is so on DDS; {wire} delivers them all the same)'
    return f'{found}{consequence}{reason}{note}'


def incompatible_type_warning(topic: str) -> str:
    """Return ROS 2's words, the same on both sides, for an endpoint of another type."""
    return f"Incompatible type on topic '{topic}', no messages will be sent to it."


class SequenceGaps:
    """Counts the messages that are missing in what publishers number from 1 on without a gap.

    What comes late or twice is not lost, and of a publisher met under way nothing counts before its first
    message (rmw_zenoh counts the distance in either direction).
    """

    def __init__(self) -> None:
        self._newest: dict[bytes, int] = {}

    def missed_before(self, publisher: bytes, sequence: int) -> int:
        """Note a message of the publisher with that gid; return how many before it never came."""
        newest = self._newest.get(publisher)
        if newest is not None and sequence <= newest:
            return 0
        self._newest[publisher] = sequence
        return 0 if newest is None else sequence - newest - 1

    def forget(self, publisher: bytes) -> None:
        """The publisher has gone."""
        self._newest.pop(publisher, None)
