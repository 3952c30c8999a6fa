from __future__ import annotations

import pytest

from goalwire.errors import UnexpectedOverrideError, UnknownPolicyError
from goalwire.rules.qos import DEFAULT, UNKNOWN, DurabilityPolicy, PolicyKind, QoS, ReliabilityPolicy
from goalwire.rules.qos_overrides import (
    may_override,
    override_description,
    override_name,
    value_of,
    with_value,
)

RELIABILITY = PolicyKind.RMW_QOS_POLICY_RELIABILITY
DEADLINE = PolicyKind.RMW_QOS_POLICY_DEADLINE
POLICIES = [policy for policy in PolicyKind if policy is not PolicyKind.RMW_QOS_POLICY_INVALID]


def test_names_and_descriptions_are_ros_2s() -> None:
    assert override_name(RELIABILITY, '/a/b', 'publisher', None) == 'qos_overrides./a/b.publisher.reliability'
    assert override_name(DEADLINE, '/a', 'subscription', 'x') == 'qos_overrides./a.subscription_x.deadline'
    described = override_description('depth', '/t', 'publisher', None)
    assert described == 'depth for publisher `/t` with id `None`'


def test_policies_are_spelled_by_short_key_number_or_yes_and_no() -> None:
    spelled = {policy.name.removeprefix('RMW_QOS_POLICY_'): value_of(DEFAULT, policy) for policy in POLICIES}
    assert spelled == {
        'DURABILITY': 'volatile',
        'DEADLINE': 0,
        'LIVELINESS': 'system_default',
        'RELIABILITY': 'reliable',
        'HISTORY': 'keep_last',
        'LIFESPAN': 0,
        'DEPTH': 10,
        'LIVELINESS_LEASE_DURATION': 0,
        'AVOID_ROS_NAMESPACE_CONVENTIONS': False,
    }


@pytest.mark.parametrize('policy', POLICIES)
def test_what_is_spelled_reads_back_as_it_was(policy: PolicyKind) -> None:
    qos = QoS(
        depth=3,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        deadline_ns=5,
        lifespan_ns=6,
        lease_ns=7,
        avoid_ros_namespace_conventions=True,
    )
    value = value_of(qos, policy)
    assert value_of(with_value(DEFAULT, policy, value), policy) == value


def test_a_value_that_no_policy_has_is_refused_with_those_there_are() -> None:
    with pytest.raises(
        UnexpectedOverrideError, match=r'policy `reliability`: `foo`: choose one of .*best_effort'
    ):
        with_value(DEFAULT, RELIABILITY, 'foo')
    with pytest.raises(RuntimeError, match='policy `deadline`: `-1`: it must be 0 or more'):
        with_value(DEFAULT, DEADLINE, -1)


def test_an_unknown_policy_cannot_be_a_default() -> None:
    with pytest.raises(
        ValueError, match=r'^User provided QoS profile is invalid: its reliability is UNKNOWN'
    ):
        value_of(UNKNOWN, RELIABILITY)
    with pytest.raises(UnknownPolicyError, match='RMW_QOS_POLICY_INVALID is not a policy'):
        value_of(DEFAULT, PolicyKind.RMW_QOS_POLICY_INVALID)


def test_a_subscription_has_no_lifespan() -> None:
    lifespan = PolicyKind.RMW_QOS_POLICY_LIFESPAN
    assert may_override(lifespan, 'publisher')
    assert not may_override(lifespan, 'subscription')
    assert may_override(DEADLINE, 'subscription')
