"""QoS profiles: constructors, defaults, presets, short keys, equality, compatibility."""

import warnings

import rclpy.qos
from rclpy.duration import Duration, Infinite
from rclpy.qos import (
    DeadlineBestAvailable,
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessLeaseDurationeBestAvailable,
    LivelinessPolicy,
    QoSCompatibility,
    QoSPolicyKind,
    QoSPresetProfiles,
    QoSProfile,
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

warnings.simplefilter('error')

QoSProfile()
QoSProfile(10)
str(QoSProfile(depth=10))
QoSProfile(history=HistoryPolicy.KEEP_LAST)
QoSProfile(history=HistoryPolicy.KEEP_ALL).depth
QoSProfile(history=HistoryPolicy.KEEP_ALL, depth=5).depth
QoSProfile(depth=5).history
QoSProfile(depth=0)
QoSProfile(depth=1.5)
QoSProfile(depth='1')
QoSProfile(depth=10, foo=1)
QoSProfile(depth=1, reliability=1).reliability
QoSProfile(depth=1, reliability='reliable')
QoSProfile(depth=1, reliability=99)
QoSProfile(depth=1, durability=ReliabilityPolicy.RELIABLE).durability
QoSProfile(depth=1, history=5)
QoSProfile(depth=1, liveliness=2)
QoSProfile(depth=1, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC).liveliness
QoSProfile(depth=1, deadline=Duration(seconds=1)).deadline
QoSProfile(depth=1, deadline=1.0)
QoSProfile(depth=1, lifespan=None)
QoSProfile(depth=1, avoid_ros_namespace_conventions=1)
QoSProfile(depth=1, avoid_ros_namespace_conventions=True).avoid_ros_namespace_conventions
p = QoSProfile(depth=7, reliability=ReliabilityPolicy.BEST_EFFORT)
p.depth = 8
p.depth
p.depth = '9'
p.reliability = 1
p.reliability
p.durability = DurabilityPolicy.TRANSIENT_LOCAL
p.lifespan = Duration(seconds=2)
str(p)
p.foo = 1
p == QoSProfile(depth=8, durability=1, lifespan=Duration(seconds=2))
p == QoSProfile(depth=8)
QoSProfile(depth=1) == 1
hash(QoSProfile(depth=1))
QoSProfile(depth=1)
[str(profile) for profile in (qos_profile_default, qos_profile_system_default, qos_profile_sensor_data)]
[str(profile) for profile in (qos_profile_services_default, qos_profile_parameters)]
[str(profile) for profile in (qos_profile_parameter_events, qos_profile_action_status_default)]
[str(profile) for profile in (qos_profile_unknown, qos_profile_best_available)]
[preset.name for preset in QoSPresetProfiles]
QoSPresetProfiles.SENSOR_DATA
QoSPresetProfiles.SENSOR_DATA.value is qos_profile_sensor_data
QoSPresetProfiles.get_from_short_key('sensor_data') is qos_profile_sensor_data
QoSPresetProfiles.get_from_short_key('x')
QoSPresetProfiles.short_keys()
[(policy.name, int(policy)) for policy in ReliabilityPolicy]
[(policy.name, int(policy)) for policy in DurabilityPolicy]
[(policy.name, int(policy)) for policy in HistoryPolicy]
[(policy.name, int(policy)) for policy in LivelinessPolicy]
ReliabilityPolicy.short_keys()
DurabilityPolicy.short_keys()
HistoryPolicy.short_keys()
LivelinessPolicy.short_keys()
ReliabilityPolicy.get_from_short_key('best_effort')
ReliabilityPolicy.get_from_short_key('BEST_EFFORT')
ReliabilityPolicy.get_from_short_key('x')
ReliabilityPolicy.get_from_short_key(1)
ReliabilityPolicy.BEST_EFFORT.short_key
ReliabilityPolicy.UNKNOWN.short_key
ReliabilityPolicy.RELIABLE == 1
qos_policy_name_from_kind(QoSPolicyKind.RELIABILITY)
qos_policy_name_from_kind(16)
qos_policy_name_from_kind(3)
qos_policy_name_from_kind('x')
[(kind.name, int(kind)) for kind in QoSPolicyKind]
DeadlineBestAvailable
LivelinessLeaseDurationeBestAvailable
[QoSCompatibility(number) for number in range(3)]
rclpy.qos.QoSHistoryPolicy is HistoryPolicy
rclpy.qos.QoSReliabilityPolicy is ReliabilityPolicy
issubclass(rclpy.qos.InvalidQoSProfileException, Exception)


def profile(**policies):
    return QoSProfile(depth=1, **policies)


SECOND, TWO = Duration(seconds=1), Duration(seconds=2)
BEST_EFFORT, TRANSIENT = ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.TRANSIENT_LOCAL
MANUAL, AUTOMATIC = LivelinessPolicy.MANUAL_BY_TOPIC, LivelinessPolicy.AUTOMATIC
qos_check_compatible(profile(), profile())
qos_check_compatible(profile(liveliness=AUTOMATIC), profile(liveliness=AUTOMATIC))
qos_check_compatible(profile(reliability=BEST_EFFORT), profile())
qos_check_compatible(profile(), profile(reliability=BEST_EFFORT))
qos_check_compatible(profile(), profile(durability=TRANSIENT))
qos_check_compatible(profile(durability=TRANSIENT), profile())
qos_check_compatible(profile(reliability=BEST_EFFORT), profile(durability=TRANSIENT))
qos_check_compatible(profile(), profile(deadline=SECOND))
qos_check_compatible(profile(deadline=SECOND), profile())
qos_check_compatible(profile(deadline=TWO), profile(deadline=SECOND))
qos_check_compatible(profile(deadline=SECOND), profile(deadline=TWO))
qos_check_compatible(profile(deadline=Infinite), profile(deadline=SECOND))
qos_check_compatible(profile(), profile(liveliness=MANUAL))
qos_check_compatible(profile(liveliness=AUTOMATIC), profile(liveliness=MANUAL))
qos_check_compatible(profile(liveliness=MANUAL), profile(liveliness=AUTOMATIC))
qos_check_compatible(profile(), profile(liveliness_lease_duration=SECOND))
qos_check_compatible(profile(liveliness_lease_duration=TWO), profile(liveliness_lease_duration=SECOND))
qos_check_compatible(profile(), qos_profile_system_default)
qos_check_compatible(qos_profile_system_default, profile())
qos_check_compatible(qos_profile_unknown, profile())
qos_check_compatible(profile(), qos_profile_unknown)
qos_check_compatible(qos_profile_best_available, profile())
qos_check_compatible(profile(), qos_profile_best_available)
qos_check_compatible(qos_profile_best_available, qos_profile_best_available)
qos_check_compatible(profile(lifespan=SECOND), profile(lifespan=TWO))
qos_check_compatible(1, profile())
