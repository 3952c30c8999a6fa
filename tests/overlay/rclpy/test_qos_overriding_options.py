"""QoS set by parameters of the node."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from helpers.spinning import MakeNode
from rclpy.exceptions import InvalidParameterTypeException, InvalidTopicNameException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import (
    HistoryPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_unknown,
)
from rclpy.qos_overriding_options import InvalidQosOverridesError, QosCallbackResult, QoSOverridingOptions
from std_msgs.msg import String

from goalwire.rules.parameters import ParameterValue

TEN = QoSProfile(depth=10)
DEFAULT = QoSOverridingOptions.with_default_policies()


@pytest.fixture
def transport_name() -> str:
    """Which wire it is does not matter here."""
    return 'goalwire_memory'


def with_overrides(make_node: MakeNode, overrides: Mapping[str, ParameterValue]) -> Node:
    return make_node(
        'n', parameter_overrides=[Parameter(name, value=value) for name, value in overrides.items()]
    )


def qos_parameters(node: Node) -> dict[str, object]:
    return {name: each.value for name, each in node.get_parameters_by_prefix('qos_overrides').items()}


def nothing(_: object) -> None:
    """Take a message."""


def test_by_default_history_depth_and_reliability_get_read_only_parameters(make_node: MakeNode) -> None:
    node = make_node('n')
    node.create_publisher(String, 'chat', TEN, qos_overriding_options=DEFAULT)
    assert qos_parameters(node) == {
        '/chat.publisher.history': 'keep_last',
        '/chat.publisher.depth': 10,
        '/chat.publisher.reliability': 'reliable',
    }
    descriptor = node.describe_parameter('qos_overrides./chat.publisher.depth')
    assert descriptor.description == 'depth for publisher `/chat` with id `None`'
    assert descriptor.read_only
    (result,) = node.set_parameters([Parameter('qos_overrides./chat.publisher.depth', value=3)])
    assert not result.successful


def test_parameters_change_the_endpoint_and_leave_the_programs_profile_alone(make_node: MakeNode) -> None:
    node = with_overrides(
        make_node,
        {
            'qos_overrides./chat.publisher.depth': 3,
            'qos_overrides./chat.publisher.reliability': 'best_effort',
        },
    )
    publisher = node.create_publisher(String, 'chat', TEN, qos_overriding_options=DEFAULT)
    assert (publisher.qos_profile.depth, publisher.qos_profile.reliability) == (
        3,
        ReliabilityPolicy.BEST_EFFORT,
    )
    (info,) = node.get_publishers_info_by_topic('chat')
    assert (info.qos_profile.depth, info.qos_profile.reliability) == (3, ReliabilityPolicy.BEST_EFFORT)
    assert QoSProfile(depth=10) == TEN


def test_arguments_may_give_them_too(make_node: MakeNode) -> None:
    arguments = ['--ros-args', '-p', 'qos_overrides./chat.subscription.history:=keep_all']
    node = make_node('n', cli_args=arguments)
    subscription = node.create_subscription(String, 'chat', nothing, 5, qos_overriding_options=DEFAULT)
    assert subscription.qos_profile.history is HistoryPolicy.KEEP_ALL


def test_the_parameters_bear_the_resolved_name_of_the_topic(make_node: MakeNode) -> None:
    node = make_node('n', namespace='ns', cli_args=['--ros-args', '-r', 'chat:=talk'])
    node.create_publisher(String, 'chat', TEN, qos_overriding_options=DEFAULT)
    assert '/ns/talk.publisher.depth' in qos_parameters(node)


def test_an_id_tells_two_of_one_topic_apart(make_node: MakeNode) -> None:
    node = with_overrides(make_node, {'qos_overrides./chat.publisher_b.depth': 3})
    a, b = (
        node.create_publisher(
            String,
            'chat',
            TEN,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(entity_id=each),
        )
        for each in 'ab'
    )
    assert (a.qos_profile.depth, b.qos_profile.depth) == (10, 3)


def test_without_an_id_the_second_one_takes_the_parameters_of_the_first(make_node: MakeNode) -> None:
    node = make_node('n')
    node.create_publisher(String, 'chat', 5, qos_overriding_options=DEFAULT)
    second = node.create_publisher(String, 'chat', 9, qos_overriding_options=DEFAULT)
    assert second.qos_profile.depth == 5


def test_all_policies_can_be_overridden_but_a_subscription_has_no_lifespan(make_node: MakeNode) -> None:
    node = make_node('n')
    everything = QoSOverridingOptions([kind for kind in QoSPolicyKind if kind is not QoSPolicyKind.INVALID])
    publisher = node.create_publisher(String, 'chat', TEN, qos_overriding_options=everything)
    subscription = node.create_subscription(String, 'chat', nothing, TEN, qos_overriding_options=everything)
    assert publisher.qos_profile == subscription.qos_profile == TEN
    names = {name.rpartition('.')[2] for name in qos_parameters(node) if 'publisher' in name}
    assert len(names) == 9
    of_subscription = {name.rpartition('.')[2] for name in qos_parameters(node) if 'subscription' in name}
    assert names - of_subscription == {'lifespan'}


def test_a_callback_judges_the_outcome(make_node: MakeNode) -> None:
    seen: list[QoSProfile] = []

    def judge(profile: QoSProfile) -> QosCallbackResult:
        seen.append(profile)
        return QosCallbackResult(successful=profile.depth < 5, reason='too deep')

    options = QoSOverridingOptions.with_default_policies(callback=judge)
    node = with_overrides(make_node, {'qos_overrides./shallow.publisher.depth': 1})
    assert node.create_publisher(String, 'shallow', TEN, qos_overriding_options=options) in node.publishers
    refusal = r'^Provided QoS overrides for publisher `/deep` with id `None`, are not valid: too deep$'
    with pytest.raises(InvalidQosOverridesError, match=refusal):
        node.create_publisher(String, 'deep', TEN, qos_overriding_options=options)
    assert [profile.depth for profile in seen] == [1, 10]
    assert node.get_publishers_info_by_topic('deep') == []


@pytest.mark.parametrize(
    ('name', 'value', 'error', 'text'),
    [
        (
            'reliability',
            'foo',
            RuntimeError,
            'Unexpected QoS override for policy `reliability`: `foo`: choose',
        ),
        ('depth', -1, RuntimeError, 'Unexpected QoS override for policy `depth`: `-1`: it must be 0 or more'),
        ('depth', '3', InvalidParameterTypeException, 'expecting type .INTEGER'),
    ],
)
def test_a_bad_override_is_refused(
    make_node: MakeNode, name: str, value: ParameterValue, error: type[Exception], text: str
) -> None:
    node = with_overrides(make_node, {f'qos_overrides./chat.publisher.{name}': value})
    with pytest.raises(error, match=text):
        node.create_publisher(String, 'chat', TEN, qos_overriding_options=DEFAULT)


def test_what_cannot_be_overridden_is_refused(make_node: MakeNode) -> None:
    node = make_node('n')
    for profile, kinds, text in (
        (qos_profile_unknown, [QoSPolicyKind.RELIABILITY], '^User provided QoS profile is invalid'),
        (TEN, [QoSPolicyKind.INVALID], 'is not a policy that a QoS profile has'),
        (TEN, ['depth'], "'depth' is not a valid PolicyKind"),
    ):
        options = QoSOverridingOptions(kinds)  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=text):
            node.create_publisher(String, 'chat', profile, qos_overriding_options=options)
    with pytest.raises(InvalidTopicNameException):
        node.create_publisher(String, 'a b', TEN, qos_overriding_options=DEFAULT)


def test_the_options_say_what_they_were_made_with() -> None:
    def callback(_: QoSProfile) -> Any:
        """Accept nothing."""

    options = QoSOverridingOptions([QoSPolicyKind.DEPTH], callback=callback, entity_id='x')
    assert (options.policy_kinds, options.callback, options.entity_id) == (
        [QoSPolicyKind.DEPTH],
        callback,
        'x',
    )
    assert DEFAULT.policy_kinds == (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY)
    assert (DEFAULT.callback, DEFAULT.entity_id) == (None, None)
