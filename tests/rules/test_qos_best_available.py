from __future__ import annotations

import pytest

from goalwire.rules.qos import (
    BEST_AVAILABLE,
    DEFAULT,
    INFINITE_NS,
    SERVICES_DEFAULT,
    SYSTEM_DEFAULT,
    DurabilityPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)
from goalwire.rules.qos_best_available import for_publisher, for_service, for_subscription, is_open
from goalwire.rules.qos_compatibility import incompatible_policy

BEST_EFFORT = ReliabilityPolicy.BEST_EFFORT
LASTING = DurabilityPolicy.TRANSIENT_LOCAL
MANUAL = LivelinessPolicy.MANUAL_BY_TOPIC
SECOND = 1_000_000_000

OTHERS = [
    [],
    [QoS(reliability=BEST_EFFORT, durability=LASTING)],
    [QoS(), QoS(reliability=BEST_EFFORT)],
    [QoS(durability=LASTING, liveliness=MANUAL), QoS(durability=LASTING, liveliness=MANUAL)],
    [QoS(deadline_ns=SECOND, lease_ns=SECOND), QoS(deadline_ns=2 * SECOND, lease_ns=3 * SECOND)],
]


def test_only_what_says_so_is_open() -> None:
    assert is_open(BEST_AVAILABLE)
    assert not is_open(DEFAULT)
    assert not is_open(SYSTEM_DEFAULT)


@pytest.mark.parametrize('publishers', OTHERS)
def test_a_subscription_goes_together_with_every_publisher_there(publishers: list[QoS]) -> None:
    qos = for_subscription(BEST_AVAILABLE, publishers)
    assert not is_open(qos)
    assert [incompatible_policy(each, qos) for each in publishers] == [None] * len(publishers)


@pytest.mark.parametrize('subscriptions', OTHERS)
def test_a_publisher_goes_together_with_every_subscription_there(subscriptions: list[QoS]) -> None:
    qos = for_publisher(BEST_AVAILABLE, subscriptions)
    assert not is_open(qos)
    assert [incompatible_policy(qos, each) for each in subscriptions] == [None] * len(subscriptions)


def test_a_subscription_asks_for_what_all_publishers_offer() -> None:
    lasting = QoS(durability=LASTING, liveliness=MANUAL)
    assert for_subscription(BEST_AVAILABLE, [lasting]).durability is LASTING
    assert for_subscription(BEST_AVAILABLE, [lasting]).liveliness is MANUAL
    assert for_subscription(BEST_AVAILABLE, [lasting, QoS()]).durability is DurabilityPolicy.VOLATILE
    assert for_subscription(BEST_AVAILABLE, [QoS(reliability=BEST_EFFORT)]).reliability is BEST_EFFORT


def test_a_subscription_without_publishers_goes_together_with_an_ordinary_one_to_come() -> None:
    assert incompatible_policy(DEFAULT, for_subscription(BEST_AVAILABLE, [])) is None


def test_durations_are_the_greatest_offered_and_the_least_asked_for() -> None:
    two = [QoS(deadline_ns=SECOND), QoS(deadline_ns=2 * SECOND), QoS(deadline_ns=INFINITE_NS)]
    assert for_subscription(BEST_AVAILABLE, two).deadline_ns == 2 * SECOND
    assert for_publisher(BEST_AVAILABLE, two).deadline_ns == SECOND
    assert for_publisher(BEST_AVAILABLE, []).lease_ns == 0


def test_what_is_not_open_stays() -> None:
    qos = QoS(reliability=ReliabilityPolicy.BEST_AVAILABLE, durability=DurabilityPolicy.VOLATILE, depth=3)
    assert for_publisher(qos, []) == QoS(durability=DurabilityPolicy.VOLATILE, depth=3)


def test_services_take_their_default() -> None:
    qos = for_service(BEST_AVAILABLE)
    assert (qos.reliability, qos.durability) == (SERVICES_DEFAULT.reliability, SERVICES_DEFAULT.durability)
    assert not is_open(qos)
