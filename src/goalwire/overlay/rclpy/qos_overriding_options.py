"""rclpy.qos_overriding_options: the QoS of a publisher or subscription set by parameters of its node.

goalwire.rules.qos_overrides has the rules for the parameters' names and values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Self, TypeAlias, Union

from goalwire.errors import InvalidQosOverridesError, ParameterAlreadyDeclaredException
from goalwire.rules import qos_overrides as rules
from goalwire.rules.qos import PolicyKind
from rclpy._reexports import reexport
from rclpy.duration import Duration
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSLivelinessPolicy,
    QoSPolicyKind,
    QoSProfile,
    QoSReliabilityPolicy,
)

if TYPE_CHECKING:
    from rcl_interfaces.msg import SetParametersResult

    from rclpy.impl.base_node import BaseNode

    QosCallbackResult: TypeAlias = SetParametersResult

__all__ = [
    'InvalidQosOverridesError',
    'QoSOverridingOptions',
    'QoSProfileAttributes',
    'QosCallbackResult',
    'QosCallbackType',
]

QosCallbackType = Callable[[QoSProfile], 'SetParametersResult']
QoSProfileAttributes = Union[  # noqa: UP007 - as rclpy has it
    QoSHistoryPolicy, int, QoSReliabilityPolicy, QoSDurabilityPolicy, Duration, QoSLivelinessPolicy, bool
]

_BY_DEFAULT = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)


class QoSOverridingOptions:
    """The policies that parameters may set, and a callback that checks the resulting profile.

    `entity_id` distinguishes several publishers or subscriptions of one node on one topic.
    """

    def __init__(
        self,
        policy_kinds: Iterable[QoSPolicyKind],
        *,
        callback: QosCallbackType | None = None,
        entity_id: str | None = None,
    ) -> None:
        self._policy_kinds = policy_kinds
        self._callback = callback
        self._entity_id = entity_id

    @property
    def policy_kinds(self) -> Iterable[QoSPolicyKind]:
        """The policies that get a parameter."""
        return self._policy_kinds

    @property
    def callback(self) -> QosCallbackType | None:
        """The function that accepts or refuses the profile that results from the overrides."""
        return self._callback

    @property
    def entity_id(self) -> str | None:
        """The suffix of the parameters' names, after the kind of endpoint."""
        return self._entity_id

    @classmethod
    def with_default_policies(
        cls, *, callback: QosCallbackType | None = None, entity_id: str | None = None
    ) -> Self:
        """Allow parameters to set history, depth and reliability."""
        return cls(_BY_DEFAULT, callback=callback, entity_id=entity_id)


def overridden(
    node: BaseNode, entity: str, topic: str, profile: QoSProfile, options: QoSOverridingOptions
) -> QoSProfile:
    """Declare the read-only parameters of an endpoint, and return the profile with their overrides.

    `entity` is 'publisher' or 'subscription', `topic` is fully qualified. Raises InvalidQosOverridesError if
    the callback refuses the profile, RuntimeError for a value that no policy has, ValueError for a profile
    with UNKNOWN policies, InvalidParameterTypeException for an override of a wrong type.
    """
    qos = profile.to_core()
    for kind in options.policy_kinds:
        policy = PolicyKind(kind)
        if rules.may_override(policy, entity):
            default = rules.value_of(qos, policy)
            value = _declare(node, policy, (topic, entity, options.entity_id), default)
            qos = rules.with_value(qos, policy, value)
    result = QoSProfile.from_core(qos)
    verdict = options.callback(result) if options.callback is not None else None
    if verdict is not None and not verdict.successful:
        whose = rules.override_description('Provided QoS overrides', topic, entity, options.entity_id)
        raise InvalidQosOverridesError(f'{whose}, are not valid: {verdict.reason}')
    return result


def _declare_qos_parameters(
    entity_type: type[object],
    node: BaseNode,
    topic_name: str,
    qos: QoSProfile,
    options: QoSOverridingOptions,
) -> None:
    """Declare the parameters of a publisher or subscription, and set their values in `qos`.

    Programs call this private function of rclpy. Raises TypeError unless `entity_type` is a Publisher or
    Subscription, and as `overridden` does.
    """
    from goalwire.entities.publisher import PublisherCore
    from goalwire.entities.subscription import SubscriptionCore

    kinds = {PublisherCore: 'publisher', SubscriptionCore: 'subscription'}
    entity = next((name for kind, name in kinds.items() if issubclass(entity_type, kind)), None)
    if entity is None:
        raise TypeError('Argument `entity_type` should be a subclass of Publisher or Subscription')
    result = overridden(node, entity, topic_name, qos, options)
    for name in QoSProfile.__slots__:
        setattr(qos, name, getattr(result, name))


def _get_qos_policy_parameter(qos: QoSProfile, policy: QoSPolicyKind) -> rules.OverrideValue:
    """Return the parameter's value for a policy of `qos`. Programs call this private function of rclpy."""
    return rules.value_of(qos.to_core(), PolicyKind(policy))


def _declare(
    node: BaseNode,
    policy: PolicyKind,
    whose: tuple[str, str, str | None],
    default: rules.OverrideValue,
) -> object:
    """Declare one QoS parameter, unless an earlier endpoint has declared it, and return its value."""
    from rcl_interfaces.msg import ParameterDescriptor

    name = rules.override_name(policy, *whose)
    description = rules.override_description(policy.policy.lower(), *whose)
    descriptor = ParameterDescriptor(description=description, read_only=True)
    try:
        parameter = node.declare_parameter(name, default, descriptor)
    except ParameterAlreadyDeclaredException:
        parameter = node.get_parameter(name)
    return parameter.value


reexport(__name__)
