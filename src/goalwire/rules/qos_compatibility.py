"""Checks whether a subscription can receive from a publisher (rmw_dds_common, qos_profile_check_compatible).

On the wire of rmw_zenoh messages arrive whatever the QoS; there the verdict tells what would happen on DDS.
The texts are ROS 2's own, with its misspelling "durabilty".
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from operator import attrgetter

from goalwire.records import record
from goalwire.rules.qos import (
    UNSPECIFIED_NS,
    DurabilityPolicy,
    LivelinessPolicy,
    PolicyKind,
    QoS,
    QoSPolicyEnum,
    ReliabilityPolicy,
)


class QoSCompatibility(IntEnum):
    """A verdict on two QoS profiles.

    WARNING: compatibility depends on what the middleware chooses for an open policy.
    """

    OK = 0
    WARNING = 1
    ERROR = 2

    def __str__(self) -> str:
        return f'{type(self).__name__}.{self.name}'

    def __format__(self, format_spec: str) -> str:
        return format(str(self), format_spec)


_OPEN = frozenset({'SYSTEM_DEFAULT', 'UNKNOWN'})


@record
class _OrderedPolicy:
    """A QoS policy with a weaker and a stronger value, and the texts for a publisher that offers less."""

    attribute: str
    kind: PolicyKind
    weak: QoSPolicyEnum
    strong: QoSPolicyEnum
    offers_too_little: str
    open_offer: str
    open_request: str
    both_open: str


_POLICIES = (
    _OrderedPolicy(
        'reliability',
        PolicyKind.RMW_QOS_POLICY_RELIABILITY,
        ReliabilityPolicy.BEST_EFFORT,
        ReliabilityPolicy.RELIABLE,
        'Best effort publisher and reliable subscription',
        'Reliable subscription, but publisher is {offer}',
        'Best effort publisher, but subscription is {request}',
        'Publisher reliability is {offer} and subscription reliability is {request}',
    ),
    _OrderedPolicy(
        'durability',
        PolicyKind.RMW_QOS_POLICY_DURABILITY,
        DurabilityPolicy.VOLATILE,
        DurabilityPolicy.TRANSIENT_LOCAL,
        'Volatile publisher and transient local subscription',
        'Transient local subscription, but publisher is {offer}',
        'Volatile publisher, but subscription is {request}',
        'Publisher durabilty is {offer} and subscription durability is {request}',
    ),
    _OrderedPolicy(
        'liveliness',
        PolicyKind.RMW_QOS_POLICY_LIVELINESS,
        LivelinessPolicy.AUTOMATIC,
        LivelinessPolicy.MANUAL_BY_TOPIC,
        "Publisher's liveliness is automatic and subscription's is manual by topic",
        "Subscription's liveliness is manual by topic, but publisher's is {offer}",
        "Publisher's liveliness is automatic, but subscription's is {request}",
        'Publisher liveliness is {offer} and subscription liveliness is {request}',
    ),
)


def check_compatible(publisher: QoS, subscription: QoS) -> tuple[QoSCompatibility, str]:
    """Return the verdict and ROS 2's reasons, each ending in ';'.

    If there are errors, warnings are left out.
    """
    errors = list(_errors(publisher, subscription))
    if errors:
        return QoSCompatibility.ERROR, ''.join(f'ERROR: {reason};' for _, reason in errors)
    warnings = list(_warnings(publisher, subscription))
    if warnings:
        return QoSCompatibility.WARNING, ''.join(f'WARNING: {reason};' for reason in warnings)
    return QoSCompatibility.OK, ''


def incompatible_policy(publisher: QoS, subscription: QoS) -> PolicyKind | None:
    """Return the policy that makes two endpoints incompatible on DDS; None if they are compatible.

    If several policies are incompatible, the one with the highest number on DDS is returned, as DDS
    implementations report it. A policy that was not set counts with the value that the wire gives it.
    """
    return max((kind for kind, _ in _errors(publisher.stated(), subscription.stated())), default=None)


def _errors(publisher: QoS, subscription: QoS) -> Iterator[tuple[PolicyKind, str]]:
    deadline, lease = PolicyKind.RMW_QOS_POLICY_DEADLINE, PolicyKind.RMW_QOS_POLICY_LIVELINESS
    reliability, durability, liveliness = _POLICIES
    yield from _too_little(reliability, publisher, subscription)
    yield from _too_little(durability, publisher, subscription)
    if publisher.deadline_ns == UNSPECIFIED_NS != subscription.deadline_ns:
        yield deadline, 'Subscription has a deadline, but publisher does not'
    elif UNSPECIFIED_NS != subscription.deadline_ns < publisher.deadline_ns:
        yield deadline, 'Subscription deadline is less than publisher deadline'
    yield from _too_little(liveliness, publisher, subscription)
    if publisher.lease_ns == UNSPECIFIED_NS != subscription.lease_ns:
        yield lease, 'Subscription has a liveliness lease duration, but publisher does not'
    elif UNSPECIFIED_NS != subscription.lease_ns < publisher.lease_ns:
        yield lease, 'Subscription liveliness lease duration is less than publisher'


def _too_little(
    policy: _OrderedPolicy, publisher: QoS, subscription: QoS
) -> Iterator[tuple[PolicyKind, str]]:
    if _value(policy, publisher) == policy.weak and _value(policy, subscription) == policy.strong:
        yield policy.kind, policy.offers_too_little


def _warnings(publisher: QoS, subscription: QoS) -> Iterator[str]:
    for policy in _POLICIES:
        offer, request = _value(policy, publisher), _value(policy, subscription)
        if offer.name in _OPEN and request == policy.strong:
            reason = policy.open_offer
        elif offer.name in _OPEN and request.name in _OPEN:
            reason = policy.both_open
        elif offer == policy.weak and request.name in _OPEN:
            reason = policy.open_request
        else:
            continue
        yield reason.format(offer=offer.short_key, request=request.short_key)


def _value(policy: _OrderedPolicy, qos: QoS) -> QoSPolicyEnum:
    value: QoSPolicyEnum = attrgetter(policy.attribute)(qos)
    return value
