from __future__ import annotations

import warnings

import pytest
from rclpy.duration import Duration, Infinite
from rclpy.qos import (
    DeadlineBestAvailable,
    DurabilityPolicy,
    HistoryPolicy,
    InvalidQoSProfileException,
    LivelinessLeaseDurationeBestAvailable,
    LivelinessPolicy,
    QoSCompatibility,
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSLivelinessPolicy,
    QoSPolicyKind,
    QoSPresetProfiles,
    QoSProfile,
    QoSReliabilityPolicy,
    ReliabilityPolicy,
    qos_check_compatible,
    qos_policy_name_from_kind,
    qos_profile_action_status_default,
    qos_profile_best_available,
    qos_profile_default,
    qos_profile_parameter_events,
    qos_profile_parameters,
    qos_profile_sensor_data,
    qos_profile_services_default,
    qos_profile_system_default,
    qos_profile_unknown,
)

from goalwire.rules import qos as core

ZERO = (
    'lifespan=0 nanoseconds, deadline=0 nanoseconds, liveliness=0, '
    'liveliness_lease_duration=0 nanoseconds, avoid_ros_namespace_conventions=False)'
)


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        ({}, 'History and/or depth settings are required.'),
        ({'reliability': ReliabilityPolicy.RELIABLE}, 'History and/or depth settings are required.'),
        ({'history': HistoryPolicy.KEEP_LAST}, 'History set to KEEP_LAST without a depth setting.'),
    ],
)
def test_a_profile_needs_a_depth_or_keep_all(arguments: dict[str, object], reason: str) -> None:
    with pytest.raises(InvalidQoSProfileException) as caught:
        QoSProfile(**arguments)  # type: ignore[arg-type]
    assert caught.value.args == ('Invalid QoSProfile', reason)


def test_a_depth_is_enough() -> None:
    assert str(QoSProfile(depth=7)) == f'QoSProfile(history=1, depth=7, reliability=1, durability=2, {ZERO}'


def test_keep_all_needs_no_depth_and_keeps_one_that_is_given() -> None:
    assert QoSProfile(history=HistoryPolicy.KEEP_ALL).depth == 10
    assert QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=5).depth == 5


def test_a_depth_of_zero_is_warned_about_where_the_profile_is_made() -> None:
    with pytest.warns(UserWarning, match="A zero depth with KEEP_LAST doesn't make sense") as caught:
        QoSProfile(depth=0)
    assert caught[0].filename == __file__


def test_a_negative_depth_is_refused() -> None:
    with pytest.raises(ValueError, match='history depth must be greater than or equal to zero'):
        QoSProfile(depth=-1)


@pytest.mark.parametrize(
    ('argument', 'value', 'text'),
    [
        ('depth', 1.5, 'QoS depth must be an int, got 1.5'),
        ('depth', '1', "QoS depth must be an int, got '1'"),
        ('reliability', 'reliable', "QoS reliability must be a ReliabilityPolicy, got 'reliable'"),
        ('deadline', 1.0, r'QoS deadline must be an rclpy.duration.Duration, got 1.0'),
        ('lifespan', None, 'QoS lifespan must be'),
        ('liveliness_lease_duration', 1, 'QoS liveliness_lease_duration must be'),
        ('avoid_ros_namespace_conventions', 1, 'must be a bool, got 1'),
    ],
)
def test_a_value_of_another_type_is_refused(argument: str, value: object, text: str) -> None:
    arguments = {'depth': 1, argument: value}
    with pytest.raises(AssertionError, match=text):
        QoSProfile(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ('argument', 'value', 'text'),
    [
        ('reliability', 99, '99 is not a valid ReliabilityPolicy'),
        ('history', 5, '5 is not a valid HistoryPolicy'),
        ('liveliness', 2, '2 is not a valid LivelinessPolicy'),
        ('durability', -1, '-1 is not a valid DurabilityPolicy'),
    ],
)
def test_a_number_outside_the_policy_is_refused(argument: str, value: int, text: str) -> None:
    arguments = {'depth': 1, argument: value}
    with pytest.raises(ValueError, match=text):
        QoSProfile(**arguments)  # type: ignore[arg-type]


def test_an_unknown_argument_is_refused() -> None:
    with pytest.raises(
        AssertionError, match=r"Invalid arguments passed to constructor: dict_keys\(\['depth', 'foo'\]\)"
    ):
        QoSProfile(depth=10, foo=1)  # type: ignore[call-arg]


def test_policies_are_taken_by_number_whatever_their_enum() -> None:
    assert QoSProfile(depth=1, reliability=2).reliability is ReliabilityPolicy.BEST_EFFORT
    profile = QoSProfile(depth=1, durability=ReliabilityPolicy.RELIABLE)
    assert profile.durability is DurabilityPolicy.TRANSIENT_LOCAL


def test_a_profile_can_be_changed_but_not_extended() -> None:
    profile = QoSProfile(depth=1)
    profile.depth = 3
    profile.deadline = Duration(seconds=1)
    assert (profile.depth, profile.deadline) == (3, Duration(seconds=1))
    with pytest.raises(AttributeError, match="'QoSProfile' object has no attribute 'foo'"):
        profile.foo = 1  # type: ignore[attr-defined]


def test_profiles_are_equal_by_value_and_not_hashable() -> None:
    assert QoSProfile(depth=7) == QoSProfile(depth=7)
    assert QoSProfile(depth=1) != QoSProfile(depth=2)
    assert QoSProfile(depth=1) != 1
    with pytest.raises(TypeError, match="unhashable type: 'QoSProfile'"):
        hash(QoSProfile(depth=1))


def test_an_endless_duration_is_printed_by_its_name() -> None:
    assert 'deadline=Infinite, ' in str(QoSProfile(depth=1, deadline=Infinite))


@pytest.mark.parametrize(
    ('profile', 'text'),
    [
        (qos_profile_default, f'history=1, depth=10, reliability=1, durability=2, {ZERO}'),
        (qos_profile_system_default, f'history=0, depth=0, reliability=0, durability=0, {ZERO}'),
        (qos_profile_sensor_data, f'history=1, depth=5, reliability=2, durability=2, {ZERO}'),
        (qos_profile_services_default, f'history=1, depth=10, reliability=1, durability=2, {ZERO}'),
        (qos_profile_parameters, f'history=1, depth=1000, reliability=1, durability=2, {ZERO}'),
        (qos_profile_parameter_events, f'history=1, depth=1000, reliability=1, durability=2, {ZERO}'),
        (qos_profile_action_status_default, f'history=1, depth=1, reliability=1, durability=1, {ZERO}'),
        (
            qos_profile_unknown,
            (
                'history=3, depth=0, reliability=3, durability=3, lifespan=0 nanoseconds, '
                'deadline=0 nanoseconds, liveliness=4, liveliness_lease_duration=0 nanoseconds, '
                'avoid_ros_namespace_conventions=False)'
            ),
        ),
        (
            qos_profile_best_available,
            (
                'history=1, depth=10, reliability=4, durability=4, lifespan=0 nanoseconds, '
                'deadline=9223372036854775806 nanoseconds, liveliness=5, '
                'liveliness_lease_duration=9223372036854775806 nanoseconds, '
                'avoid_ros_namespace_conventions=False)'
            ),
        ),
    ],
)
def test_presets_have_ros_2s_values(profile: QoSProfile, text: str) -> None:
    assert str(profile) == f'QoSProfile({text}'


def test_presets_are_found_by_short_key() -> None:
    assert QoSPresetProfiles.SENSOR_DATA.value is qos_profile_sensor_data
    assert QoSPresetProfiles.get_from_short_key('sensor_data') is qos_profile_sensor_data
    assert QoSPresetProfiles.short_keys() == [
        'unknown',
        'default',
        'system_default',
        'sensor_data',
        'services_default',
        'parameters',
        'parameter_events',
        'action_status_default',
        'best_available',
        'rosout_default',
    ]
    with pytest.raises(KeyError, match='X'):
        QoSPresetProfiles.get_from_short_key('x')


def test_policies_are_found_by_short_key() -> None:
    assert ReliabilityPolicy.get_from_short_key('best_effort') == ReliabilityPolicy.BEST_EFFORT
    assert LivelinessPolicy.MANUAL_BY_TOPIC.short_key == 'manual_by_topic'
    assert HistoryPolicy.short_keys() == ['system_default', 'keep_last', 'keep_all', 'unknown']


def test_the_old_names_of_the_policies_are_the_same_classes() -> None:
    assert (QoSHistoryPolicy, QoSReliabilityPolicy) == (HistoryPolicy, ReliabilityPolicy)
    assert (QoSDurabilityPolicy, QoSLivelinessPolicy) == (DurabilityPolicy, LivelinessPolicy)


def test_kinds_of_policies_have_names() -> None:
    assert qos_policy_name_from_kind(16) == 'RELIABILITY'
    assert qos_policy_name_from_kind(QoSPolicyKind.AVOID_ROS_NAMESPACE_CONVENTIONS) == (
        'AVOID_ROS_NAMESPACE_CONVENTIONS'
    )
    with pytest.raises(ValueError, match='3 is not a valid QoSPolicyKind'):
        qos_policy_name_from_kind(3)


def test_best_available_durations_are_one_below_infinite() -> None:
    assert DeadlineBestAvailable.nanoseconds == Infinite.nanoseconds - 1
    assert DeadlineBestAvailable == LivelinessLeaseDurationeBestAvailable


def test_a_profile_survives_the_way_down_and_up() -> None:
    profile = QoSProfile(
        depth=3,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        lifespan=Duration(seconds=1),
        deadline=Duration(seconds=2),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        liveliness_lease_duration=Duration(seconds=3),
        avoid_ros_namespace_conventions=True,
    )
    assert profile.to_core() == core.QoS(
        depth=3,
        reliability=ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
        lifespan_ns=1_000_000_000,
        deadline_ns=2_000_000_000,
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
        lease_ns=3_000_000_000,
        avoid_ros_namespace_conventions=True,
    )
    assert QoSProfile.from_core(profile.to_core()) == profile


def test_a_peers_odd_profile_is_shown_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert QoSProfile.from_core(core.QoS(depth=0)).depth == 0


def test_a_depth_may_stand_for_a_profile() -> None:
    profile = QoSProfile(depth=4)
    assert QoSProfile.of(profile) is profile
    assert QoSProfile.of(4) == profile


@pytest.mark.parametrize('value', [None, 'x', 1.5])
def test_what_is_neither_profile_nor_depth_is_refused(value: object) -> None:
    with pytest.raises(TypeError, match='Expected QoSProfile or int, but received '):
        QoSProfile.of(value)  # type: ignore[arg-type]


def test_compatibility_is_judged_on_profiles() -> None:
    publisher = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    assert qos_check_compatible(publisher, QoSProfile(depth=1)) == (
        QoSCompatibility.ERROR,
        'ERROR: Best effort publisher and reliable subscription;',
    )
    assert qos_check_compatible(qos_profile_best_available, QoSProfile(depth=1)) == (QoSCompatibility.OK, '')


def test_a_verdict_is_printed_by_its_name() -> None:
    assert (str(QoSCompatibility.OK), f'{QoSCompatibility.ERROR}') == (
        'QoSCompatibility.OK',
        'QoSCompatibility.ERROR',
    )
    assert int(QoSCompatibility.WARNING) == 1
