"""The body as its walker knows it: the model's inertia and Jacobians at the estimated state, by MuJoCo."""

from __future__ import annotations

import mujoco
import numpy as np

from humanoid.physics.build import Robot
from humanoid.walking.seam import Array

SIDES = (0, 1)


class Body:
    """Positions, Jacobians and the equations of motion of one robot at one state."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._data = mujoco.MjData(robot.model)
        nv = robot.model.nv
        self._moving, self._turning = np.zeros((3, nv)), np.zeros((3, nv))
        self.inertia = np.zeros((nv, nv))
        self.jacobians = [np.zeros((6, nv)) for _ in SIDES]  # of each sole: rows for position, then rotation
        self.drifts = [np.zeros(6) for _ in SIDES]  # m/s², rad/s²: of the soles while no joint accelerates
        self._mass = float(robot.model.body_subtreemass[0])

    @property
    def mass(self) -> float:
        return self._mass

    def set(self, position: Array, orientation: Array, velocity: Array, angles: Array, speeds: Array) -> None:
        """Set a state: the pelvis' position (m), quaternion (w, x, y, z), velocity (6, in MuJoCo's order)."""
        robot, data = self.robot, self._data
        data.qpos[:3], data.qpos[3:7], data.qvel[:6] = position, orientation, velocity
        data.qpos[robot.qpos], data.qvel[robot.dofs] = angles, speeds
        model = robot.model
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_passive(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)
        mujoco.mj_subtreeVel(model, data)
        mujoco.mj_fullM(model, data, self.inertia)
        for side, leg in enumerate(robot.legs):
            jacobian = self.jacobians[side]
            mujoco.mj_jacSite(model, data, self._moving, self._turning, leg.sole)
            jacobian[:3], jacobian[3:] = self._moving, self._turning
            point = data.site_xpos[leg.sole]
            mujoco.mj_jacDot(model, data, self._moving, self._turning, point, leg.foot)
            self.drifts[side][:3] = self._moving @ data.qvel
            self.drifts[side][3:] = self._turning @ data.qvel

    def shift(self, way: Array, faster: Array) -> None:
        """Correct the pelvis' position (m) and velocity (m/s) after `set`, with all that depends on them."""
        data = self._data
        data.qpos[:3] += way
        data.site_xpos[:] += way
        data.subtree_com[:] += way
        data.qvel[:3] += faster
        data.subtree_linvel[:] += faster

    @property
    def bias(self) -> Array:
        """Coriolis force, gravity and friction: what the motors must overcome in each degree of freedom."""
        return np.asarray(self._data.qfrc_bias - self._data.qfrc_passive)

    def joint(self, index: int) -> tuple[float, float]:
        """Return the angle and the speed of a joint, in rad and rad/s."""
        return float(self._data.qpos[self.robot.qpos[index]]), float(self._data.qvel[self.robot.dofs[index]])

    @property
    def position(self) -> Array:
        """The pelvis' position, in m."""
        return np.asarray(self._data.qpos[:3])

    @property
    def speeds(self) -> Array:
        return np.asarray(self._data.qvel)

    @property
    def centre(self) -> Array:
        """The centre of mass, in m."""
        return np.asarray(self._data.subtree_com[1])

    @property
    def centre_velocity(self) -> Array:
        return np.asarray(self._data.subtree_linvel[1])

    @property
    def pelvis(self) -> Array:
        """The rotation matrix from the pelvis' axes to the world's."""
        return np.asarray(self._data.xmat[1]).reshape(3, 3)

    def sole(self, side: int) -> Array:
        """Return the position of the middle of a sole, in m."""
        return np.array(self._data.site_xpos[self.robot.legs[side].sole])

    def sole_turn(self, side: int) -> Array:
        """Return the rotation matrix from a sole's axes to the world's."""
        return np.array(self._data.site_xmat[self.robot.legs[side].sole]).reshape(3, 3)

    def sole_speed(self, side: int) -> Array:
        return np.asarray(self.jacobians[side] @ self._data.qvel)
