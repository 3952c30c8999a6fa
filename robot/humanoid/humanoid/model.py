"""The humanoid in numbers: its joints, its base and its battery. Every limit has its one home here."""

from __future__ import annotations

from dataclasses import dataclass

MOVING_SPEED = 0.01  # rad/s for a joint, m/s for the base: slower than this is at rest
GREATEST_SPEED = 100.0  # the same units: no robot of this kind is that fast, whatever a message says


@dataclass(frozen=True)
class JointSpec:
    """One revolute joint: angles in rad, velocity in rad/s, friction in N·m per rad/s."""

    name: str
    home: float
    lower: float
    upper: float
    max_velocity: float
    friction: float


JOINTS = (
    JointSpec('left_arm_shoulder', home=0.5, lower=-2.9, upper=2.9, max_velocity=2.0, friction=4.0),
    JointSpec('left_arm_elbow', home=0.0, lower=0.0, upper=2.4, max_velocity=2.5, friction=2.0),
    JointSpec('right_arm_shoulder', home=-0.5, lower=-2.9, upper=2.9, max_velocity=2.0, friction=4.0),
    JointSpec('right_arm_elbow', home=0.0, lower=0.0, upper=2.4, max_velocity=2.5, friction=2.0),
    JointSpec('left_knee', home=0.0, lower=-0.1, upper=2.2, max_velocity=3.0, friction=8.0),
    JointSpec('right_knee', home=0.0, lower=-0.1, upper=2.2, max_velocity=3.0, friction=8.0),
)

JOINT_BY_NAME = {joint.name: joint for joint in JOINTS}


@dataclass(frozen=True)
class BaseSpec:
    """The base stands on the floor of the frame `odom` and moves in any direction."""

    max_speed: float = 0.8  # m/s
    max_turn_rate: float = 1.5  # rad/s


BASE = BaseSpec()


@dataclass(frozen=True)
class BatterySpec:
    """Charge in ampere hours, current in A, voltage in V; draws add up."""

    capacity: float = 15.0
    empty_voltage: float = 42.0
    full_voltage: float = 54.6
    idle_draw: float = 4.0
    draw_per_base_speed: float = 25.0  # A per m/s
    draw_per_joint_speed: float = 6.0  # A per rad/s, summed over the joints
    charge_current: float = 12.0
    rest_before_charging: float = 2.0  # s without motion until the dock's contacts close


BATTERY = BatterySpec()
