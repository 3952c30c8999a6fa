"""Turns BEST_AVAILABLE into concrete policies that suit the present endpoints (rmw_dds_common, qos.cpp).

A subscription requests the strictest policies that all publishers offer. A publisher always offers the
strictest policies. One rule differs from rmw_dds_common: without publishers a subscription requests only the
policies that an ordinary publisher offers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum

from goalwire.records import replace
from goalwire.rules.qos import (
    BEST_AVAILABLE_NS,
    INFINITE_NS,
    SERVICES_DEFAULT,
    UNSPECIFIED_NS,
    DurabilityPolicy,
    LivelinessPolicy,
    QoS,
    ReliabilityPolicy,
)

_UNSET = frozenset({UNSPECIFIED_NS, INFINITE_NS, BEST_AVAILABLE_NS})


def is_open(qos: QoS) -> bool:
    """Tell whether some policy is BEST_AVAILABLE: endpoints on the other side decide its value."""
    return (
        qos.reliability is ReliabilityPolicy.BEST_AVAILABLE
        or qos.durability is DurabilityPolicy.BEST_AVAILABLE
        or qos.liveliness is LivelinessPolicy.BEST_AVAILABLE
        or BEST_AVAILABLE_NS in (qos.deadline_ns, qos.lease_ns)
    )


def for_subscription(qos: QoS, publishers: Sequence[QoS]) -> QoS:
    """Return the QoS of a subscription that receives from all of these publishers."""

    def all_offer(policy: str, value: IntEnum) -> bool:
        return bool(publishers) and all(getattr(each, policy) is value for each in publishers)

    best_effort = any(each.reliability is ReliabilityPolicy.BEST_EFFORT for each in publishers)
    lasting = all_offer('durability', DurabilityPolicy.TRANSIENT_LOCAL)
    manual = all_offer('liveliness', LivelinessPolicy.MANUAL_BY_TOPIC)
    offer = QoS(
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if lasting else DurabilityPolicy.VOLATILE,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC,
        deadline_ns=_choose_duration(max, (each.deadline_ns for each in publishers)),
        lease_ns=_choose_duration(max, (each.lease_ns for each in publishers)),
    )
    return _fill_in(qos, offer)


def for_publisher(qos: QoS, subscriptions: Sequence[QoS]) -> QoS:
    """Return the QoS of a publisher from which all of these subscriptions can receive."""
    manual = any(each.liveliness is LivelinessPolicy.MANUAL_BY_TOPIC for each in subscriptions)
    request = QoS(
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC if manual else LivelinessPolicy.AUTOMATIC,
        deadline_ns=_choose_duration(min, (each.deadline_ns for each in subscriptions)),
        lease_ns=_choose_duration(min, (each.lease_ns for each in subscriptions)),
    )
    return _fill_in(qos, request)


def for_service(qos: QoS) -> QoS:
    """Return the QoS of a service or client: BEST_AVAILABLE policies become the default of services."""
    return _fill_in(qos, SERVICES_DEFAULT)


def _choose_duration(choose: Callable[[Iterable[int]], int], durations: Iterable[int]) -> int:
    """Return the greatest or the smallest of the specified durations."""
    stated = [each for each in durations if each not in _UNSET]
    return choose(stated) if stated else UNSPECIFIED_NS


def _fill_in(qos: QoS, found: QoS) -> QoS:
    """Replace the BEST_AVAILABLE policies of `qos` by those of `found`."""
    return replace(
        qos,
        reliability=(
            found.reliability if qos.reliability is ReliabilityPolicy.BEST_AVAILABLE else qos.reliability
        ),
        durability=found.durability if qos.durability is DurabilityPolicy.BEST_AVAILABLE else qos.durability,
        liveliness=found.liveliness if qos.liveliness is LivelinessPolicy.BEST_AVAILABLE else qos.liveliness,
        deadline_ns=found.deadline_ns if qos.deadline_ns == BEST_AVAILABLE_NS else qos.deadline_ns,
        lease_ns=found.lease_ns if qos.lease_ns == BEST_AVAILABLE_NS else qos.lease_ns,
    )
