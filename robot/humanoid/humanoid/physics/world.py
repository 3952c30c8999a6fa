"""The world: the robot's body under its controller, a tick at a time. It knows no ROS and no real time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.physics.build import GRAVITY, Array, Robot, build
from humanoid.physics.gait import Gait
from humanoid.physics.legs import Legs

TICK = 0.01  # s between two looks of the controller
STEPS = 5  # of the physics in a tick
STANDS_AT = 0.98  # of the pelvis' height above straight legs
WALKS_AT = 0.94  # the same: room for long steps
SINKS = 0.2  # m/s, from one to the other
SCATTER = 0.002  # rad by which the seed lets joints start off their set-points
SETTLE = 50  # ticks before the world's time begins, in which the robot comes to stand
UPRIGHT_ABOVE = 0.85  # of the height above straight legs: a pelvis below it has fallen


# MuJoCo would print its warnings, and write them into a file of the working directory; Unstable tells all.
mujoco.set_mju_user_warning(lambda _text: None)


class Unstable(Exception):
    """The physics came to values that are not finite; the text says when and which."""


@dataclass(frozen=True)
class Inertial:
    """What an inertial sensor in the pelvis shows, in its own frame: rad/s, and m/s² with gravity in it."""

    turn_rate: tuple[float, float, float]
    acceleration: tuple[float, float, float]


class World:
    """One robot on a floor. The same seed and the same calls between the same ticks give the same bits.

    `controllers` are called at the beginning of each tick, with the world's time in s; they call `aim` and
    `drive`.
    """

    def __init__(self, urdf: str, home: Mapping[str, float] | None = None, seed: int = 0) -> None:
        """`home` has the angles (rad) of joints that do not start at zero. Raises NotARobot."""
        self.robot: Robot = build(urdf)
        self.controllers: list[Callable[[float], None]] = []
        self.ticks = 0
        self.energy = 0.0  # J that the motors have done, braking counted like driving
        self.power = 0.0  # W, the same, during the last tick
        self.loads = (0.0, 0.0)  # N on the left and on the right sole
        self.halted = False
        self._index = {name: index for index, name in enumerate(self.robot.names)}
        self._data = mujoco.MjData(self.robot.model)
        self._legs = Legs(self.robot)
        self._leg_joints = np.concatenate([leg.joints for leg in self.robot.legs])
        self._jacobian = np.zeros((3, self.robot.model.nv))
        self._foot_of_body = {leg.foot: side for side, leg in enumerate(self.robot.legs)}
        self._fastest = np.full(len(self.robot.names), np.inf)
        self._held = np.zeros(len(self.robot.names), dtype=bool)  # joints of the legs that are not the gait's
        self._goals = np.zeros(len(self.robot.names))
        for name, angle in (home or {}).items():
            self._goals[self._index[name]] = angle
        self._base_goal, self._base_speed = Pose2D(), STANDING
        self._gait = Gait(self._legs.half_width, Pose2D())
        self.height = STANDS_AT * self._legs.straight_height  # m that the pelvis shall be above the floor
        self._set_points = self._stand_up(np.random.default_rng(seed))
        for _ in range(SETTLE):
            self.tick()
        self.ticks, self.energy = 0, 0.0

    def _stand_up(self, chance: np.random.Generator) -> Array:
        """Place the robot on the floor, knees a little bent; the joints' set-points."""
        angles = self._goals.copy()
        self._place_legs(angles, Pose2D())
        others = np.ones(len(angles), dtype=bool)
        others[self._leg_joints] = False
        self._data.qpos[2] = self.height
        self._data.qpos[self.robot.qpos] = angles + others * chance.uniform(-SCATTER, SCATTER, len(angles))
        mujoco.mj_forward(self.robot.model, self._data)
        return angles

    @property
    def time(self) -> float:
        """Seconds since the world began."""
        return self.ticks * TICK

    @property
    def pose(self) -> Pose2D:
        """The pelvis above the floor."""
        x, y, _, yaw = map(float, self._data.qpos[:4])
        return Pose2D(x, y, math.remainder(yaw, math.tau))

    @property
    def velocity(self) -> Velocity2D:
        """The pelvis' velocity in its own frame."""
        vx, vy, _, turn = map(float, self._data.qvel[:4])
        cos, sin = math.cos(self._data.qpos[3]), math.sin(self._data.qpos[3])
        return Velocity2D(cos * vx + sin * vy, cos * vy - sin * vx, turn)

    @property
    def pelvis_height(self) -> float:
        return float(self._data.qpos[2])

    @property
    def walking(self) -> bool:
        return self._gait.walking

    @property
    def steps(self) -> int:
        """How many steps the feet have made."""
        return self._gait.steps

    @property
    def fallen(self) -> bool:
        """Whether the pelvis has sunk lower than any step brings it."""
        return self.pelvis_height < UPRIGHT_ABOVE * self._legs.straight_height

    @property
    def inertial(self) -> Inertial:
        turn = self._data.sensor('base_gyro').data
        pull = self._data.sensor('base_accelerometer').data
        return Inertial(
            (float(turn[0]), float(turn[1]), float(turn[2])), (float(pull[0]), float(pull[1]), float(pull[2]))
        )

    def joint(self, name: str) -> tuple[float, float, float]:
        """Angle, speed and the motor's torque of a joint: rad, rad/s, N·m; of a sliding one m, m/s, N."""
        index = self._index[name]
        dof = self.robot.dofs[index]
        return (
            float(self._data.qpos[self.robot.qpos[index]]),
            float(self._data.qvel[dof]),
            float(self._data.qfrc_actuator[dof]),
        )

    def sole(self, side: int) -> tuple[float, float, float]:
        """Where the point below the left (0) or the right (1) ankle is, in m, on the floor's own axes."""
        x, y, z = self._data.site_xpos[self.robot.legs[side].sole]
        return float(x), float(y), float(z)

    def state(self) -> bytes:
        """All positions and velocities, bit for bit."""
        return bytes(self._data.qpos.tobytes() + self._data.qvel.tobytes())

    def limit_speed(self, name: str, fastest: float) -> None:
        """Let a joint's set-point move no faster than `fastest` rad/s."""
        self._fastest[self._index[name]] = fastest

    def aim(self, name: str, angle: float) -> None:
        """Where a joint shall be, in rad. Walking takes the joints of the legs back."""
        index = self._index[name]
        self._goals[index], self._held[index] = angle, True

    def set_point(self, name: str) -> float:
        """Where the joint's motor is told to be at this tick, in rad."""
        return float(self._set_points[self._index[name]])

    def hold(self, name: str) -> None:
        """Stop a joint at its present set-point."""
        self.aim(name, self.set_point(name))

    def drive(self, pose: Pose2D, velocity: Velocity2D) -> None:
        """Where the pelvis shall be, and how fast it shall move, in its own frame."""
        self._base_goal, self._base_speed = pose, velocity

    def halt(self) -> None:
        """Hold every joint and the pelvis where they are, in mid-step too, until `resume`."""
        self.halted = True
        self._set_points = np.array(self._data.qpos[self.robot.qpos])
        self._goals = self._set_points.copy()
        self._base_goal, self._base_speed = self.pose, STANDING

    def resume(self) -> None:
        """Let the joints and the pelvis be moved again, from where they are."""
        self.halted = False

    def tick(self) -> None:
        """Let TICK seconds pass. Raises Unstable."""
        if not self.halted:
            for control in self.controllers:
                control(self.time)
        self._command(self._next_set_points())
        mujoco.mj_step(self.robot.model, self._data, STEPS)
        self.ticks += 1
        self._check()
        self._measure()

    def _next_set_points(self) -> Array:
        if self.halted:
            return self._set_points
        base, wanted = self.pose, self._goals.copy()
        self._gait.update(TICK, base, self._base_speed)
        if self._gait.walking:
            self._held[:] = False
        wanted_height = (WALKS_AT if self._gait.walking else STANDS_AT) * self._legs.straight_height
        self.height += min(max(wanted_height - self.height, -SINKS * TICK), SINKS * TICK)
        self._place_legs(wanted, base)
        most = self._fastest * TICK
        return self._set_points + np.minimum(np.maximum(wanted - self._set_points, -most), most)

    def _place_legs(self, angles: Array, base: Pose2D) -> None:
        """Set the angles of those joints of the legs that are the gait's."""
        solved = self._legs.solve(base, self.height, self._gait.feet)
        for leg, own in zip(self.robot.legs, solved, strict=True):
            for joint, angle in zip(leg.joints, own, strict=True):
                if not self._held[joint]:
                    angles[joint] = angle

    def _command(self, set_points: Array) -> None:
        """Give the motors their set-points, with speeds, and the torques that carry the robot's weight."""
        robot, data = self.robot, self._data
        speeds = (set_points - self._set_points) / TICK
        self._set_points = set_points
        weights = self._weights()[robot.dofs]
        extra = (robot.damping * speeds[robot.motors] + weights[robot.motors]) / robot.stiffness
        data.ctrl[robot.BASE_MOTORS :] = set_points[robot.motors] + extra
        goal, speed = self._base_goal, self._base_speed
        yaw = float(data.qpos[3])
        cos, sin = math.cos(yaw), math.sin(yaw)
        ahead = robot.base_damping / robot.base_stiffness
        data.ctrl[0] = goal.x + ahead[0] * (cos * speed.x - sin * speed.y)
        data.ctrl[1] = goal.y + ahead[1] * (sin * speed.x + cos * speed.y)
        data.ctrl[2] = yaw + turn_between(yaw, goal.yaw) + ahead[2] * speed.yaw

    def _weights(self) -> Array:
        """The torques that carry the links, and through the standing legs the whole robot."""
        robot, data = self.robot, self._data
        torques = np.array(data.qfrc_bias)
        for leg, foot in zip(robot.legs, self._gait.feet, strict=True):
            if foot.load > 0.0:
                mujoco.mj_jacSite(robot.model, data, self._jacobian, None, leg.sole)
                torques[leg.dofs] -= self._jacobian[2, leg.dofs] * (foot.load * robot.mass * GRAVITY)
        return torques

    def _check(self) -> None:
        data = self._data
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            raise Unstable(f'after {self.time:.2f} s the state of the robot is not a number')

    def _measure(self) -> None:
        robot, data = self.robot, self._data
        motors = robot.dofs[robot.motors]
        self.power = float(np.abs(data.qfrc_actuator[motors] * data.qvel[motors]).sum())
        self.energy += self.power * TICK
        loads, force = [0.0, 0.0], np.zeros(6)
        geoms = data.contact.geom
        for number in range(data.ncon):
            one, other = geoms[number]
            body = robot.model.geom_bodyid[one if other == robot.floor else other]
            side = self._foot_of_body.get(int(body))
            if side is not None:
                mujoco.mj_contactForce(robot.model, data, number, force)
                loads[side] += float(force[0])
        self.loads = (loads[0], loads[1])
