from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.rules.qos import (
    BEST_AVAILABLE_NS,
    INFINITE_NS,
    DurabilityPolicy,
    LivelinessPolicy,
    PolicyKind,
    QoS,
    ReliabilityPolicy,
)
from goalwire.rules.qos_compatibility import QoSCompatibility, check_compatible, incompatible_policy

SECOND = 1_000_000_000
DURATIONS = {'0': 0, '1': SECOND, '2': 2 * SECOND, 'inf': INFINITE_NS, 'best': BEST_AVAILABLE_NS}
TABLE = Path(__file__).parent.parent / 'data' / 'qos_compatibility.tsv'
ROWS = [
    line.split('\t')
    for line in TABLE.read_text(encoding='utf-8').splitlines()
    if line and not line.startswith('#')
]


def qos(policy: str, value: str) -> QoS:
    automatic = LivelinessPolicy.AUTOMATIC
    match policy:
        case 'reliability':
            return QoS(liveliness=automatic, reliability=ReliabilityPolicy[value])
        case 'durability':
            return QoS(liveliness=automatic, durability=DurabilityPolicy[value])
        case 'liveliness':
            return QoS(liveliness=LivelinessPolicy[value])
        case 'deadline':
            return QoS(liveliness=automatic, deadline_ns=DURATIONS[value])
        case _:
            return QoS(liveliness=automatic, lease_ns=DURATIONS[value])


def test_the_table_is_complete() -> None:
    assert len(ROWS) == 125


@pytest.mark.parametrize(('policy', 'publisher', 'subscription', 'verdict', 'reason'), ROWS)
def test_one_policy_is_judged_as_ros_2_judges_it(
    policy: str, publisher: str, subscription: str, verdict: str, reason: str
) -> None:
    found = check_compatible(qos(policy, publisher), qos(policy, subscription))
    assert found == (QoSCompatibility[verdict], reason)


def test_all_errors_are_listed_and_no_warnings_beside_them() -> None:
    publisher = QoS(reliability=ReliabilityPolicy.BEST_EFFORT, liveliness=LivelinessPolicy.AUTOMATIC)
    subscription = QoS(
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        deadline_ns=SECOND,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        lease_ns=SECOND,
    )
    assert check_compatible(publisher, subscription) == (
        QoSCompatibility.ERROR,
        (
            'ERROR: Best effort publisher and reliable subscription;'
            'ERROR: Volatile publisher and transient local subscription;'
            'ERROR: Subscription has a deadline, but publisher does not;'
            "ERROR: Publisher's liveliness is automatic and subscription's is manual by topic;"
            'ERROR: Subscription has a liveliness lease duration, but publisher does not;'
        ),
    )


def test_all_warnings_are_listed_in_order() -> None:
    system_default = QoS(
        reliability=ReliabilityPolicy.SYSTEM_DEFAULT, durability=DurabilityPolicy.SYSTEM_DEFAULT
    )
    unknown = QoS(
        reliability=ReliabilityPolicy.UNKNOWN,
        durability=DurabilityPolicy.UNKNOWN,
        liveliness=LivelinessPolicy.UNKNOWN,
    )
    assert check_compatible(system_default, unknown) == (
        QoSCompatibility.WARNING,
        (
            'WARNING: Publisher reliability is system_default and subscription reliability is unknown;'
            'WARNING: Publisher durabilty is system_default and subscription durability is unknown;'
            'WARNING: Publisher liveliness is system_default and subscription liveliness is unknown;'
        ),
    )


@pytest.mark.parametrize(
    ('publisher', 'subscription', 'policy'),
    [
        (QoS(), QoS(), None),
        (QoS(reliability=ReliabilityPolicy.BEST_EFFORT), QoS(), 'RELIABILITY'),
        (QoS(), QoS(durability=DurabilityPolicy.TRANSIENT_LOCAL), 'DURABILITY'),
        (QoS(), QoS(deadline_ns=SECOND), 'DEADLINE'),
        (QoS(), QoS(lease_ns=SECOND), 'LIVELINESS'),
        (QoS(), QoS(liveliness=LivelinessPolicy.MANUAL_BY_TOPIC), 'LIVELINESS'),
        (QoS(deadline_ns=SECOND), QoS(deadline_ns=INFINITE_NS), None),
        (QoS(deadline_ns=INFINITE_NS), QoS(), None),
        (QoS(reliability=ReliabilityPolicy.SYSTEM_DEFAULT), QoS(), None),
        (
            QoS(reliability=ReliabilityPolicy.BEST_EFFORT),
            QoS(durability=DurabilityPolicy.TRANSIENT_LOCAL, deadline_ns=SECOND),
            'RELIABILITY',
        ),
    ],
)
def test_the_policy_that_keeps_two_endpoints_apart(
    publisher: QoS, subscription: QoS, policy: str | None
) -> None:
    expected = None if policy is None else PolicyKind[f'RMW_QOS_POLICY_{policy}']
    assert incompatible_policy(publisher, subscription) is expected
