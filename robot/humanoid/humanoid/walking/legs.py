"""The joint angles of a robot that stands: knees bent, the centre of mass above the middle of its soles."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from humanoid.physics.build import NotARobot, Robot
from humanoid.walking.seam import Array

ACCURATE = 1e-6  # m: a sole may be off the floor by this much; beyond it the legs have another build
AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (1, 0, 0))
BUILD = 'hip yaw, roll, pitch, knee, ankle pitch and roll'


class Legs:
    """The legs of a robot, measured at their straight pose."""

    def __init__(self, robot: Robot) -> None:
        """Raises NotARobot if a leg does not have the six expected joints."""
        self._robot = robot
        data = mujoco.MjData(robot.model)
        mujoco.mj_kinematics(robot.model, data)
        for leg in robot.legs:
            axes = data.xaxis[robot.model.dof_jntid[leg.dofs]]
            if len(axes) != len(AXES) or not np.allclose(axes, AXES):
                raise NotARobot(f'a leg has not the six joints {BUILD}')
        leg = robot.legs[0]
        hip, knee, ankle = (data.xanchor[robot.model.dof_jntid[leg.dofs[number]]] for number in (2, 3, 5))
        self._hip = hip - data.xpos[1]
        self._thigh, self._shin = float(hip[2] - knee[2]), float(knee[2] - ankle[2])
        self._sole = data.site_xpos[leg.sole] - ankle
        self.straight_height = float(data.xpos[1][2] - data.site_xpos[leg.sole][2])

    def stand(self, height: float, angles: Array) -> Array:
        """Return all joints' angles for a robot that stands with its pelvis `height` m above the floor.

        Raises NotARobot.
        """
        robot, stands = self._robot, angles.copy()
        data = mujoco.MjData(robot.model)
        for _ in range(3):  # repeated, since bending the legs moves the centre of mass
            data.qpos[3], data.qpos[robot.qpos] = 1.0, stands
            mujoco.mj_kinematics(robot.model, data)
            mujoco.mj_comPos(robot.model, data)
            bent = self._bend(float(data.subtree_com[1][0] - self._sole[0]), height)
            for leg in robot.legs:
                stands[leg.joints] = bent
        self._check(data, stands, height)
        return stands

    def _bend(self, ahead: float, height: float) -> tuple[float, ...]:
        """Return a leg's angles, bent so that the ankle is `ahead` m in front of the pelvis' middle."""
        x, z = ahead - float(self._hip[0]), height + float(self._hip[2] + self._sole[2])
        distance = math.hypot(x, z)
        thigh, shin = self._thigh, self._shin
        bend = (distance**2 - thigh**2 - shin**2) / (2.0 * thigh * shin)
        if not -1.0 < bend < 1.0:
            raise NotARobot(f'the legs cannot hold the pelvis {height:.2f} m up')
        knee = math.acos(bend)
        hip = math.atan2(-x, z) - math.asin(shin * math.sin(knee) / distance)
        return 0.0, 0.0, hip, knee, -hip - knee, 0.0

    def _check(self, data: Any, angles: Array, height: float) -> None:
        robot = self._robot
        data.qpos[2], data.qpos[robot.qpos] = height, angles
        mujoco.mj_kinematics(robot.model, data)
        for leg in robot.legs:
            level = data.site_xmat[leg.sole].reshape(3, 3)[2, 2]
            if abs(data.site_xpos[leg.sole][2]) > ACCURATE or level < 1.0 - ACCURATE:
                raise NotARobot(f'the legs are not {BUILD}')
