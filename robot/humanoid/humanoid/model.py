"""The humanoid in numbers: its joints, its base and its battery.

The joints' limits are defined in the description (humanoid.description), all other numbers here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from humanoid.description import urdf_text
from humanoid.urdf import Description, UrdfJoint, parse

MOVING_SPEED = 0.01  # rad/s of a joint, m/s of the base: below this speed it counts as at rest
GREATEST_SPEED = 100.0  # rad/s or m/s: a message with a higher speed is taken as wrong

# These joints come first in every list of joints, whatever their order in the URDF.
FIRST = (
    'left_arm_shoulder',
    'left_arm_elbow',
    'right_arm_shoulder',
    'right_arm_elbow',
    'left_knee',
    'right_knee',
)
HOME = {'left_arm_shoulder': 0.5, 'right_arm_shoulder': -0.5}  # rad; all other joints start at 0


@dataclass(frozen=True)
class JointSpec:
    """One joint: angles in rad, velocity in rad/s, friction in N·m per rad/s, effort in N·m.

    For a prismatic joint, m and N take the place of rad and N·m.
    """

    name: str
    home: float
    lower: float
    upper: float
    max_velocity: float
    friction: float
    max_effort: float = 0.0
    prismatic: bool = False

    @property
    def unit(self) -> str:
        return 'm' if self.prismatic else 'rad'

    @property
    def arrived_within(self) -> float:
        """The distance from its target, in rad or m, within which the joint counts as arrived."""
        return 0.001 if self.prismatic else 0.01


DESCRIPTION: Description = parse(urdf_text())


def _spec(joint: UrdfJoint) -> JointSpec:
    return JointSpec(
        joint.name,
        HOME.get(joint.name, 0.0),
        joint.lower,
        joint.upper,
        joint.velocity,
        joint.damping,
        joint.effort,
        joint.kind == 'prismatic',
    )


def _motors(description: Description) -> Sequence[JointSpec]:
    """The joints that have a motor of their own."""
    driven = [name for name, joint in description.joints.items() if joint.moves and joint.mimic is None]
    return [
        _spec(description.joints[name]) for name in (*FIRST, *(each for each in driven if each not in FIRST))
    ]


JOINTS = tuple(_motors(DESCRIPTION))
JOINT_BY_NAME = {joint.name: joint for joint in JOINTS}


@dataclass(frozen=True)
class BaseSpec:
    """The base, which moves in any direction on the floor: its limits and its size."""

    max_speed: float = 0.8  # m/s
    max_turn_rate: float = 1.5  # rad/s
    radius: float = 0.4  # m: radius of a disc about base_link that contains the robot with its arms at home


BASE = BaseSpec()


@dataclass(frozen=True)
class BatterySpec:
    """Capacity in Ah, currents in A, voltages in V; the draws (currents while discharging) add up."""

    capacity: float = 15.0
    empty_voltage: float = 42.0
    full_voltage: float = 54.6
    idle_draw: float = 4.0
    draw_per_base_speed: float = 25.0  # A per m/s
    draw_per_joint_speed: float = 6.0  # A per rad/s of joint speed, summed over the joints
    charge_current: float = 12.0
    idle_power: float = 1.0  # W: with less power the motors count as at rest
    rest_before_charging: float = 2.0  # s without motion after which charging begins


BATTERY = BatterySpec()
