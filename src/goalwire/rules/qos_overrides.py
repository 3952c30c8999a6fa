"""QoS set by parameters: `qos_overrides./topic.publisher.depth` and so on (rclpy.qos_overriding_options)."""

from __future__ import annotations

from typing import TypeAlias

from goalwire.errors import UnexpectedOverrideError, UnknownPolicyError
from goalwire.records import replace
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    PolicyKind,
    QoS,
    QoSPolicyEnum,
    ReliabilityPolicy,
)

OverrideValue: TypeAlias = str | int | bool
"""The value of a parameter for a policy: a short key, a number (nanoseconds for durations), or a bool."""

_FIELDS = {
    PolicyKind.RMW_QOS_POLICY_DURABILITY: 'durability',
    PolicyKind.RMW_QOS_POLICY_DEADLINE: 'deadline_ns',
    PolicyKind.RMW_QOS_POLICY_LIVELINESS: 'liveliness',
    PolicyKind.RMW_QOS_POLICY_RELIABILITY: 'reliability',
    PolicyKind.RMW_QOS_POLICY_HISTORY: 'history',
    PolicyKind.RMW_QOS_POLICY_LIFESPAN: 'lifespan_ns',
    PolicyKind.RMW_QOS_POLICY_DEPTH: 'depth',
    PolicyKind.RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION: 'lease_ns',
    PolicyKind.RMW_QOS_POLICY_AVOID_ROS_NAMESPACE_CONVENTIONS: 'avoid_ros_namespace_conventions',
}

_CHOICES: dict[PolicyKind, type[QoSPolicyEnum]] = {
    PolicyKind.RMW_QOS_POLICY_DURABILITY: DurabilityPolicy,
    PolicyKind.RMW_QOS_POLICY_LIVELINESS: LivelinessPolicy,
    PolicyKind.RMW_QOS_POLICY_RELIABILITY: ReliabilityPolicy,
    PolicyKind.RMW_QOS_POLICY_HISTORY: HistoryPolicy,
}


def override_name(policy: PolicyKind, topic: str, entity: str, entity_id: str | None) -> str:
    """Return the name of the parameter that sets a policy.

    `entity`: 'publisher' or 'subscription'; `topic`: its full name.
    """
    suffix = '' if entity_id is None else f'_{entity_id}'
    return f'qos_overrides.{topic}.{entity}{suffix}.{policy.policy.lower()}'


def override_description(what: str, topic: str, entity: str, entity_id: str | None) -> str:
    """Return ROS 2's description of the parameter that sets a policy; `what` is the policy's name."""
    return f'{what} for {entity} `{topic}` with id `{entity_id}`'


def may_override(policy: PolicyKind, entity: str) -> bool:
    """Tell whether a policy exists for a kind of endpoint: only publishers have a lifespan."""
    return policy is not PolicyKind.RMW_QOS_POLICY_LIFESPAN or entity == 'publisher'


def value_of(qos: QoS, policy: PolicyKind) -> OverrideValue:
    """Return the parameter's value that stands for a policy of `qos`; raises UnknownPolicyError."""
    if policy not in _FIELDS:
        raise UnknownPolicyError(f'{policy.name} is not a policy that a QoS profile has')
    value: OverrideValue = getattr(qos, _FIELDS[policy])
    if isinstance(value, QoSPolicyEnum):
        if value.name == 'UNKNOWN':
            raise UnknownPolicyError(
                f'User provided QoS profile is invalid: its {_FIELDS[policy]} is UNKNOWN'
            )
        return value.short_key
    return value


def with_value(qos: QoS, policy: PolicyKind, value: object) -> QoS:
    """Return `qos` with a policy set to the value of a parameter; raises UnexpectedOverrideError."""
    choices = _CHOICES.get(policy)
    if choices is not None:
        try:
            value = choices[str(value).upper()]
        except KeyError:
            raise _describe_unexpected(
                policy, value, f'choose one of {", ".join(choices.short_keys())}'
            ) from None
    elif isinstance(value, int) and value < 0:
        raise _describe_unexpected(policy, value, 'it must be 0 or more')
    # The declaration of the parameter has ensured the value's type.
    return replace(qos, **{_FIELDS[policy]: value})


def _describe_unexpected(policy: PolicyKind, value: object, choice: str) -> UnexpectedOverrideError:
    return UnexpectedOverrideError(
        f'Unexpected QoS override for policy `{policy.policy.lower()}`: `{value}`: {choice}'
    )
