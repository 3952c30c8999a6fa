"""The gestures: a gesture is a list of movements, and a movement maps joint names to angles in rad."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from humanoid.model import JOINT_BY_NAME, JOINTS

QUICKEST = 0.4  # s that a movement takes at least
UNHURRIED = 1.25  # factor on the time that a joint needs at its greatest velocity
WAVES = 3

Movement = Mapping[str, float]

_RAISED = {'right_arm_shoulder': -2.4, 'right_arm_elbow': 0.4}
WAVE: Sequence[Movement] = (
    _RAISED,
    *({'right_arm_elbow': angle} for _ in range(WAVES) for angle in (1.2, 0.4)),
    {name: JOINT_BY_NAME[name].home for name in _RAISED},
)
STAND: Sequence[Movement] = ({joint.name: joint.home for joint in JOINTS},)


def time_unhurried(movement: Movement, here: Mapping[str, float]) -> float:
    """Return the seconds that an unhurried movement takes from the present joint angles."""
    ways = [abs(angle - here[name]) / JOINT_BY_NAME[name].max_velocity for name, angle in movement.items()]
    return max(QUICKEST, UNHURRIED * max(ways))
