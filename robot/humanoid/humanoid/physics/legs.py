"""Joint angles that put the soles where the gait wants them: inverse kinematics in closed form.

A leg is six joints: hip yaw, roll and pitch through one point, a knee, ankle pitch and roll through another.
Such a leg has one solution with the knee forward (Kajita et al., Introduction to Humanoid Robotics, 2.5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid.navigation.base import Pose2D, turn_between
from humanoid.physics.build import NotARobot, Robot
from humanoid.physics.gait import Foot

LEAST_BEND = 0.06  # rad of the knee: a foot farther away than that is only approached
ACCURATE = 1e-6  # m and rad: what a leg of another build would miss
AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 0, 0))

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Segments:
    """A leg's measures, in m: the hip in the pelvis' frame, and how far it is from joint to joint."""

    hip: Vector
    thigh: float
    shin: float
    ankle: float  # above the sole


class Legs:
    """Both legs of a robot."""

    def __init__(self, robot: Robot) -> None:
        """Raises NotARobot where the legs are of another build."""
        data = mujoco.MjData(robot.model)
        mujoco.mj_kinematics(robot.model, data)
        self._segments = [_measured(robot, data, side) for side in (0, 1)]
        left, right = self._segments
        self.half_width = (left.hip[1] - right.hip[1]) / 2.0
        self.straight_height = left.thigh + left.shin + left.ankle - left.hip[2]
        self._check(robot, data)

    def solve(self, base: Pose2D, height: float, feet: Sequence[Foot]) -> tuple[Sequence[float], ...]:
        """The six angles of each leg that put its sole where `feet` say; the pelvis is `height` m up."""
        cos, sin = math.cos(base.yaw), math.sin(base.yaw)
        solved = []
        for segments, foot in zip(self._segments, feet, strict=True):
            dx, dy = foot.x - base.x, foot.y - base.y
            ankle = (
                cos * dx + sin * dy - segments.hip[0],
                cos * dy - sin * dx - segments.hip[1],
                foot.z + segments.ankle - height - segments.hip[2],
            )
            solved.append(_angles(segments, ankle, turn_between(base.yaw, foot.yaw), foot.pitch))
        return tuple(solved)

    def _check(self, robot: Robot, data: Any) -> None:
        """Compare with MuJoCo's own kinematics, at a step in mid-air."""
        width, height = self.half_width, 0.92 * self.straight_height
        feet = (Foot(0.1, width, 0.0, 0.1, 0.0, 0.5), Foot(-0.08, -1.1 * width, 0.04, -0.1, 0.1, 0.5))
        solved = self.solve(Pose2D(), height, feet)
        data.qpos[2] = height
        for leg, angles in zip(robot.legs, solved, strict=True):
            data.qpos[leg.qpos] = angles
        mujoco.mj_kinematics(robot.model, data)
        for leg, foot, segments in zip(robot.legs, feet, self._segments, strict=True):
            turned = data.xmat[leg.foot].reshape(3, 3)
            wanted = (foot.x, foot.y, foot.z + segments.ankle)
            off = float(np.abs(data.xpos[leg.foot] - wanted).max())
            turn = abs(math.atan2(turned[1, 0], turned[0, 0]) - foot.yaw)
            level = abs(math.asin(-turned[2, 0]) - foot.pitch) + abs(turned[2, 1])
            if max(off, turn, level) > ACCURATE:
                raise NotARobot('the legs are not hip yaw, roll, pitch, knee, ankle pitch and roll')


def _measured(robot: Robot, data: Any, side: int) -> Segments:
    leg = robot.legs[side]
    joints = robot.model.dof_jntid[leg.dofs]
    if len(joints) != len(AXES) or not np.allclose(data.xaxis[joints], AXES):
        raise NotARobot('a leg has not the six joints hip yaw, roll, pitch, knee, ankle pitch and roll')
    hip, knee, ankle = (data.xanchor[joints[number]] for number in (2, 3, 5))
    return Segments(
        (float(hip[0]), float(hip[1]), float(hip[2])),
        float(hip[2] - knee[2]),
        float(knee[2] - ankle[2]),
        float(ankle[2] - data.site_xpos[leg.sole, 2]),
    )


def _angles(leg: Segments, ankle: Vector, yaw: float, pitch: float) -> Sequence[float]:
    """The angles for an ankle seen from the hip; heading and pitch of the foot are in the pelvis' frame."""
    x, y, z = ankle
    distance = math.sqrt(x * x + y * y + z * z)
    farthest = math.sqrt(leg.thigh**2 + leg.shin**2 + 2.0 * leg.thigh * leg.shin * math.cos(LEAST_BEND))
    if distance > farthest:
        x, y, z = (part * farthest / distance for part in (x, y, z))
        distance = farthest
    bend = (distance**2 - leg.thigh**2 - leg.shin**2) / (2.0 * leg.thigh * leg.shin)
    knee = math.acos(max(-1.0, min(1.0, bend)))
    # The hip, seen from the ankle in the foot's own axes.
    cos, sin = math.cos(yaw), math.sin(yaw)
    ahead, left, up = -(cos * x + sin * y), -(cos * y - sin * x), -z
    cp, sp = math.cos(pitch), math.sin(pitch)
    ahead, up = cp * ahead - sp * up, sp * ahead + cp * up
    tilt = math.asin(leg.thigh * math.sin(knee) / distance)
    ankle_roll = math.atan2(left, up)
    ankle_pitch = -math.atan2(ahead, math.copysign(math.hypot(left, up), up)) - tilt
    # What the hip has to turn: the foot's orientation, less what knee and ankle have turned.
    cr, sr = math.cos(-ankle_roll), math.sin(-ankle_roll)
    cb, sb = math.cos(-(knee + ankle_pitch)), math.sin(-(knee + ankle_pitch))
    foot = ((cos * cp, -sin, cos * sp), (sin * cp, cos, sin * sp), (-sp, 0.0, cp))
    rows = [(a, b * cr + c * sr, c * cr - b * sr) for a, b, c in foot]
    rows = [(a * cb - c * sb, b, a * sb + c * cb) for a, b, c in rows]
    hip_yaw = math.atan2(-rows[0][1], rows[1][1])
    cy, sy = math.cos(hip_yaw), math.sin(hip_yaw)
    hip_roll = math.atan2(rows[2][1], -rows[0][1] * sy + rows[1][1] * cy)
    hip_pitch = math.atan2(-rows[2][0], rows[2][2])
    return hip_yaw, hip_roll, hip_pitch, knee, ankle_pitch, ankle_roll
