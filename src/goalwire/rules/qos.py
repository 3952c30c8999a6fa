"""QoS policies, and QoS, the frozen profile that all layers below the public APIs use.

Numbers are those of rmw/types.h (rmw_qos_*_policy_e); durations are nanoseconds.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Self

from goalwire.records import record, replace

if TYPE_CHECKING:
    from collections.abc import Collection

UNSPECIFIED_NS = 0
"""The duration that leaves the choice to the middleware (RMW_DURATION_UNSPECIFIED)."""
INFINITE_NS = 9_223_372_036_854_775_807
"""A duration without end (RMW_DURATION_INFINITE: 9223372036 s, 854775807 ns)."""
BEST_AVAILABLE_NS = INFINITE_NS - 1
"""The duration that suits the endpoints on the other side (RMW_DURATION_BEST_AVAILABLE)."""


class QoSPolicyEnum(IntEnum):
    """The base of the enums of policies. Each value also has a short key, its name in lower case."""

    @classmethod
    def short_keys(cls) -> list[str]:
        """Return the short key of every value."""
        return [member.short_key for member in cls]

    @classmethod
    def get_from_short_key(cls, name: str) -> int:
        """Return the number of the value with a short key; raises KeyError for an unknown key."""
        return cls[name.upper()].value

    @property
    def short_key(self) -> str:
        """The value's name in lower case, which parameters and command lines use."""
        return self.name.lower()

    @classmethod
    def of(cls, value: int) -> Self:
        """Return the enum's value with a number; raises ValueError as ROS 2 does."""
        return cls(value)


class HistoryPolicy(QoSPolicyEnum):
    """The rule by which a queue keeps messages: only the last ones, or all."""

    SYSTEM_DEFAULT = 0
    KEEP_LAST = 1
    KEEP_ALL = 2
    UNKNOWN = 3


class ReliabilityPolicy(QoSPolicyEnum):
    """The rule for lost messages: whether messages are sent again until they arrive."""

    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class DurabilityPolicy(QoSPolicyEnum):
    """The rule for late subscribers: whether these get earlier messages."""

    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2
    UNKNOWN = 3
    BEST_AVAILABLE = 4


class LivelinessPolicy(QoSPolicyEnum):
    """The rule by which a publisher shows that it is alive."""

    SYSTEM_DEFAULT = 0
    AUTOMATIC = 1
    MANUAL_BY_TOPIC = 3
    UNKNOWN = 4
    BEST_AVAILABLE = 5


class PolicyKind(IntEnum):
    """The numbers of policies in the records of events (rmw_qos_policy_kind_t)."""

    RMW_QOS_POLICY_INVALID = 1 << 0
    RMW_QOS_POLICY_DURABILITY = 1 << 1
    RMW_QOS_POLICY_DEADLINE = 1 << 2
    RMW_QOS_POLICY_LIVELINESS = 1 << 3
    RMW_QOS_POLICY_RELIABILITY = 1 << 4
    RMW_QOS_POLICY_HISTORY = 1 << 5
    RMW_QOS_POLICY_LIFESPAN = 1 << 6
    RMW_QOS_POLICY_DEPTH = 1 << 7
    RMW_QOS_POLICY_LIVELINESS_LEASE_DURATION = 1 << 8
    RMW_QOS_POLICY_AVOID_ROS_NAMESPACE_CONVENTIONS = 1 << 9

    @property
    def policy(self) -> str:
        """The name of the policy without a prefix: 'RELIABILITY' and so on."""
        return self.name.split('_', 3)[-1]


@record
class QoS:
    """The quality of service that a user requests for one endpoint."""

    depth: int = 10
    history: HistoryPolicy = HistoryPolicy.KEEP_LAST
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE
    deadline_ns: int = UNSPECIFIED_NS
    lifespan_ns: int = UNSPECIFIED_NS
    liveliness: LivelinessPolicy = LivelinessPolicy.SYSTEM_DEFAULT
    lease_ns: int = UNSPECIFIED_NS
    avoid_ros_namespace_conventions: bool = False

    def to_dict(self) -> dict[str, object]:
        """Return the profile as keyword arguments of rclpy.qos.QoSProfile."""
        from goalwire.rules.time import Duration

        return {
            'depth': self.depth,
            'history': self.history,
            'reliability': self.reliability,
            'durability': self.durability,
            'lifespan': Duration(nanoseconds=self.lifespan_ns),
            'deadline': Duration(nanoseconds=self.deadline_ns),
            'liveliness': self.liveliness,
            'liveliness_lease_duration': Duration(nanoseconds=self.lease_ns),
            'avoid_ros_namespace_conventions': self.avoid_ros_namespace_conventions,
        }

    @property
    def keeps_all(self) -> bool:
        """True if the queue keeps all messages, without a limit."""
        return self.history is HistoryPolicy.KEEP_ALL

    @property
    def is_transient_local(self) -> bool:
        """True if late subscribers get messages from the publisher's history."""
        return self.durability is DurabilityPolicy.TRANSIENT_LOCAL

    @property
    def is_reliable(self) -> bool:
        """True for every reliability except best effort."""
        return self.reliability is not ReliabilityPolicy.BEST_EFFORT

    def stated(self) -> QoS:
        """Return the profile in which policies that the user left open have the values that a peer sees.

        These values are: keep last, reliable, volatile, automatic liveliness, no time limits.
        """
        return replace(
            self,
            history=self.history or HistoryPolicy.KEEP_LAST,
            reliability=self.reliability or ReliabilityPolicy.RELIABLE,
            durability=self.durability or DurabilityPolicy.VOLATILE,
            liveliness=self.liveliness or LivelinessPolicy.AUTOMATIC,
            deadline_ns=self.deadline_ns or INFINITE_NS,
            lifespan_ns=self.lifespan_ns or INFINITE_NS,
            lease_ns=self.lease_ns or INFINITE_NS,
        )


DEFAULT = QoS()
SENSOR_DATA = QoS(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
SERVICES_DEFAULT = QoS()
PARAMETERS = QoS(depth=1000)
PARAMETER_EVENTS = QoS(depth=1000)
ACTION_STATUS_DEFAULT = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROSOUT = QoS(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan_ns=10_000_000_000)
SYSTEM_DEFAULT = QoS(
    depth=0,
    history=HistoryPolicy.SYSTEM_DEFAULT,
    reliability=ReliabilityPolicy.SYSTEM_DEFAULT,
    durability=DurabilityPolicy.SYSTEM_DEFAULT,
)
UNKNOWN = QoS(
    depth=0,
    history=HistoryPolicy.UNKNOWN,
    reliability=ReliabilityPolicy.UNKNOWN,
    durability=DurabilityPolicy.UNKNOWN,
    liveliness=LivelinessPolicy.UNKNOWN,
)
BEST_AVAILABLE = QoS(
    reliability=ReliabilityPolicy.BEST_AVAILABLE,
    durability=DurabilityPolicy.BEST_AVAILABLE,
    deadline_ns=BEST_AVAILABLE_NS,
    liveliness=LivelinessPolicy.BEST_AVAILABLE,
    lease_ns=BEST_AVAILABLE_NS,
)


def suiting(offered: Collection[QoS], depth: int) -> QoS:
    """Return the QoS of a subscription that is compatible with publishers of these QoS.

    The rule is that of ROS 2's `topic echo`: the subscription is reliable if there are publishers and all of
    them are reliable, and transient local if there are publishers and all of them are transient local.
    """
    reliable = bool(offered) and all(each.stated().is_reliable for each in offered)
    latched = bool(offered) and all(each.is_transient_local for each in offered)
    return QoS(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
