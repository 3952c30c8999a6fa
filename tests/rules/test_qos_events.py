from __future__ import annotations

import pytest

from goalwire.rules.qos import PolicyKind
from goalwire.rules.qos_events import (
    NOTHING_YET,
    IncompatibleQoS,
    LivelinessChanged,
    Matched,
    MessageLost,
    OfferedDeadlineMissed,
    PublisherEvent,
    RequestedDeadlineMissed,
    SequenceGaps,
    SubscriptionEvent,
    changes_between,
    incompatible_qos_warning,
    with_fields,
)

RELIABILITY = PolicyKind.RMW_QOS_POLICY_RELIABILITY
OFFERED = PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS
REQUESTED = SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS


def test_events_have_the_numbers_of_rcl() -> None:
    assert [int(event) for event in PublisherEvent] == [0, 1, 2, 3, 4]
    assert [int(event) for event in SubscriptionEvent] == [0, 1, 2, 3, 4, 5]


def test_an_event_of_a_publisher_is_none_of_a_subscription_although_the_numbers_are_equal() -> None:
    matched, other = (
        PublisherEvent.RCL_PUBLISHER_MATCHED,
        SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE,
    )
    assert int(matched) == int(other)
    assert matched != other  # type: ignore[comparison-overlap]


def test_every_event_has_a_record() -> None:
    assert set(NOTHING_YET) == {*PublisherEvent, *SubscriptionEvent}


def test_records_of_another_kind_are_never_equal() -> None:
    assert RequestedDeadlineMissed(1, 1) == RequestedDeadlineMissed(1, 1)
    assert RequestedDeadlineMissed(1, 1) != OfferedDeadlineMissed(1, 1)
    assert len({RequestedDeadlineMissed(), RequestedDeadlineMissed(), OfferedDeadlineMissed()}) == 2


def test_changes_are_counted_since_the_record_before() -> None:
    assert changes_between(MessageLost(3), MessageLost(10)) == MessageLost(10, 7)
    matched = changes_between(Matched(2, 2, 2, 2), Matched(3, current_count=1))
    assert matched == Matched(3, 1, current_count=1, current_count_change=-1)
    alive = LivelinessChanged(alive_count=2, not_alive_count=1)
    assert changes_between(LivelinessChanged(3, 3), alive) == LivelinessChanged(2, -1, 1, 1)


def test_what_is_no_count_stays_as_it_is() -> None:
    later = IncompatibleQoS(2, last_policy_kind=RELIABILITY)
    assert changes_between(IncompatibleQoS(), later) == IncompatibleQoS(2, 2, RELIABILITY)
    assert with_fields(later, total_count=5) == IncompatibleQoS(5, 0, RELIABILITY)


def test_a_record_says_what_it_holds() -> None:
    assert repr(MessageLost(3, 1)) == 'MessageLost(total_count=3, total_count_change=1)'


@pytest.mark.parametrize(
    ('event', 'said'),
    [
        (
            OFFERED,
            (
                "New subscription discovered on topic 'chat', requesting incompatible QoS. "
                'No messages will be sent to it. Last incompatible policy: RELIABILITY'
                '; write reliability=ReliabilityPolicy.RELIABLE in the QoSProfile of the publisher, '
                'or BEST_EFFORT in that of the subscription'
            ),
        ),
        (
            REQUESTED,
            (
                "New publisher discovered on topic 'chat', offering incompatible QoS. "
                'No messages will be received from it. Last incompatible policy: RELIABILITY'
                '; write reliability=ReliabilityPolicy.RELIABLE in the QoSProfile of the publisher, '
                'or BEST_EFFORT in that of the subscription'
            ),
        ),
    ],
)
def test_the_warning_is_ros_2s_own_and_true_on_every_wire(
    event: PublisherEvent | SubscriptionEvent, said: str
) -> None:
    assert incompatible_qos_warning(event, 'chat', RELIABILITY, wire=None) == said
    lenient = incompatible_qos_warning(event, 'chat', RELIABILITY, wire='rmw_zenoh_cpp')
    assert 'With DDS, as on most robots, no messages will be ' in lenient
    assert 'with rmw_zenoh_cpp, which runs here, they arrive. ' in lenient
    assert 'No messages' not in lenient
    assert lenient.partition(' QoS. ')[0] == said.partition(' QoS. ')[0]
    assert lenient.partition('Last ')[2] == said.partition('Last ')[2]


def test_gaps_are_counted_for_each_publisher() -> None:
    gaps = SequenceGaps()
    arrived = [(b'a', 1), (b'a', 2), (b'b', 7), (b'a', 5), (b'b', 8)]
    assert [gaps.count_missed(*each) for each in arrived] == [0, 0, 0, 2, 0]


def test_what_comes_late_or_twice_is_not_lost() -> None:
    gaps = SequenceGaps()
    assert [gaps.count_missed(b'a', number) for number in (10, 7, 8, 10, 11)] == [0, 0, 0, 0, 0]


def test_a_publisher_that_went_is_forgotten() -> None:
    gaps = SequenceGaps()
    gaps.count_missed(b'a', 1)
    gaps.discard(b'a')
    assert gaps.count_missed(b'a', 9) == 0
