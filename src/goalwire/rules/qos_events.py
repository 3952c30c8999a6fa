"""QoS events of publishers and subscriptions: their kinds, and their status records.

Names and numbers are those of rcl/event.h (rcl_publisher_event_type_t, rcl_subscription_event_type_t). The
records are those of rmw/events_statuses. A source of events keeps only totals. A reader of events computes
changes as the difference of two records (`changes_between`), so any number of readers may share one source.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TypeAlias, TypeVar

from goalwire.rules.qos import PolicyKind


class _EventType(Enum):
    """The base of the kinds of events; int() returns rcl's number."""

    __hash__ = object.__hash__  # faster: Enum's own hash is a Python function, and members are unique objects

    def __int__(self) -> int:
        number: int = self.value
        return number


class PublisherEvent(_EventType):
    """The events of a publisher."""

    RCL_PUBLISHER_OFFERED_DEADLINE_MISSED = 0
    RCL_PUBLISHER_LIVELINESS_LOST = 1
    RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS = 2
    RCL_PUBLISHER_INCOMPATIBLE_TYPE = 3
    RCL_PUBLISHER_MATCHED = 4


class SubscriptionEvent(_EventType):
    """The events of a subscription."""

    RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED = 0
    RCL_SUBSCRIPTION_LIVELINESS_CHANGED = 1
    RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS = 2
    RCL_SUBSCRIPTION_MESSAGE_LOST = 3
    RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE = 4
    RCL_SUBSCRIPTION_MATCHED = 5


EventType: TypeAlias = PublisherEvent | SubscriptionEvent


class EventStatus:
    """A record of the totals of one kind of event so far. Records with equal fields are equal."""

    __slots__: Sequence[str] = ()

    def _identity(self) -> tuple[object, ...]:
        return (type(self), *(getattr(self, name) for name in self.__slots__))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, EventStatus) and self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def __repr__(self) -> str:
        fields = ', '.join(f'{name}={getattr(self, name)!r}' for name in self.__slots__)
        return f'{type(self).__name__}({fields})'


class _Count(EventStatus):
    __slots__ = ('total_count', 'total_count_change')

    def __init__(self, total_count: int = 0, total_count_change: int = 0) -> None:
        self.total_count = total_count
        self.total_count_change = total_count_change


class OfferedDeadlineMissed(_Count):
    """The number of times that a publisher exceeded the deadline that it offers."""


class RequestedDeadlineMissed(_Count):
    """The number of times that no message came within the deadline that a subscription requests."""


class LivelinessLost(_Count):
    """The number of times that a publisher failed to show that it is alive."""


class MessageLost(_Count):
    """The number of messages that did not arrive."""


class IncompatibleType(_Count):
    """The number of endpoints on the same topic with another type."""


class LivelinessChanged(EventStatus):
    """The numbers of publishers that are alive, and of those that are not alive any more."""

    __slots__ = ('alive_count', 'alive_count_change', 'not_alive_count', 'not_alive_count_change')

    def __init__(
        self,
        alive_count: int = 0,
        alive_count_change: int = 0,
        not_alive_count: int = 0,
        not_alive_count_change: int = 0,
    ) -> None:
        self.alive_count = alive_count
        self.alive_count_change = alive_count_change
        self.not_alive_count = not_alive_count
        self.not_alive_count_change = not_alive_count_change


class Matched(EventStatus):
    """The numbers of endpoints that have ever matched, and that match at present."""

    __slots__ = ('current_count', 'current_count_change', 'total_count', 'total_count_change')

    def __init__(
        self,
        total_count: int = 0,
        total_count_change: int = 0,
        current_count: int = 0,
        current_count_change: int = 0,
    ) -> None:
        self.total_count = total_count
        self.total_count_change = total_count_change
        self.current_count = current_count
        self.current_count_change = current_count_change


class IncompatibleQoS(EventStatus):
    """The number of endpoints with incompatible QoS, and the policy that is incompatible at the last one."""

    __slots__ = ('last_policy_kind', 'total_count', 'total_count_change')

    def __init__(
        self,
        total_count: int = 0,
        total_count_change: int = 0,
        last_policy_kind: PolicyKind = PolicyKind.RMW_QOS_POLICY_INVALID,
    ) -> None:
        self.total_count = total_count
        self.total_count_change = total_count_change
        self.last_policy_kind = last_policy_kind


StatusT = TypeVar('StatusT', bound=EventStatus)

_CHANGE = '_change'


def changes_between(earlier: StatusT, later: StatusT) -> StatusT:
    """Return the later record, with the changes since the earlier record of the same kind filled in."""
    return with_fields(
        later,
        **{
            name: getattr(later, counted) - getattr(earlier, counted)
            for name in later.__slots__
            if (counted := name.removesuffix(_CHANGE)) != name
        },
    )


def with_fields(status: StatusT, **changed: int) -> StatusT:
    """Return a copy of a record with some fields changed."""
    return type(status)(**{name: getattr(status, name) for name in status.__slots__} | changed)


NOTHING_YET: dict[EventType, EventStatus] = {
    PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED: OfferedDeadlineMissed(),
    PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST: LivelinessLost(),
    PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS: IncompatibleQoS(),
    PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE: IncompatibleType(),
    PublisherEvent.RCL_PUBLISHER_MATCHED: Matched(),
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED: RequestedDeadlineMissed(),
    SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED: LivelinessChanged(),
    SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS: IncompatibleQoS(),
    SubscriptionEvent.RCL_SUBSCRIPTION_MESSAGE_LOST: MessageLost(),
    SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE: IncompatibleType(),
    SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED: Matched(),
}
"""The record of each kind before its first event."""


_REMEDIES = {
    PolicyKind.RMW_QOS_POLICY_RELIABILITY: (
        '; write reliability=ReliabilityPolicy.RELIABLE in the QoSProfile of the publisher, '
        'or BEST_EFFORT in that of the subscription'
    ),
    PolicyKind.RMW_QOS_POLICY_DURABILITY: (
        '; write durability=DurabilityPolicy.TRANSIENT_LOCAL in the QoSProfile of the publisher, '
        'or VOLATILE in that of the subscription'
    ),
}


def incompatible_qos_warning(event: EventType, topic: str, policy: PolicyKind, *, wire: str | None) -> str:
    """Return ROS 2's warning that an endpoint on the other side of a topic has an incompatible QoS.

    `wire` names a wire that delivers messages in spite of that, which the text then says; None for DDS.
    """
    if isinstance(event, PublisherEvent):
        found = f"New subscription discovered on topic '{topic}', requesting incompatible QoS. "
        consequence = 'o messages will be sent to it'
    else:
        found = f"New publisher discovered on topic '{topic}', offering incompatible QoS. "
        consequence = 'o messages will be received from it'
    limits = (
        f'N{consequence}. '
        if wire is None
        else f'With DDS, as on most robots, n{consequence}; with {wire}, which runs here, they arrive. '
    )
    return f'{found}{limits}Last incompatible policy: {policy.policy}{_REMEDIES.get(policy, "")}'


class SequenceGaps:
    """Counts the missing messages of publishers that number their messages from 1 on without gaps.

    A message that comes late or twice does not count as lost. The messages that a publisher sent before the
    first received message do not count, either. (rmw_zenoh also counts a step backwards in the numbers as
    lost messages.)
    """

    def __init__(self) -> None:
        self._newest: dict[bytes, int] = {}

    def count_missed(self, publisher: bytes, sequence: int) -> int:
        """Note a message of a publisher, and return the number of missing messages just before it."""
        newest = self._newest.get(publisher)
        if newest is not None and sequence <= newest:
            return 0
        self._newest[publisher] = sequence
        return 0 if newest is None else sequence - newest - 1

    def discard(self, publisher: bytes) -> None:
        """Forget a publisher that has gone."""
        self._newest.pop(publisher, None)
