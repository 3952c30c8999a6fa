"""The simulated world: the robot's body and its walker, advanced by ticks, without ROS or real time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from humanoid.navigation.base import Placement, Pose2D, Velocity2D
from humanoid.physics.build import Array, Robot, build
from humanoid.physics.falling import give_way, has_fallen
from humanoid.physics.senses import USUAL, Noise, Senses
from humanoid.physics.touch import Touch, find_touches
from humanoid.physics.truth import read_rotation, truth_of
from humanoid.walking.legs import Legs
from humanoid.walking.seam import Estimate, Walker, Wish
from humanoid.walking.walker import DcmWalker

TICK = 0.01  # s between two calls of the controllers
PERIODS = 2  # updates of the walker in each tick
STEPS = 2  # steps of the physics for each update of the walker
SCATTER = 0.002  # rad: largest random offset of a joint's start angle
SETTLE = 100  # ticks before the world's time begins, for the robot to come to rest


# Unstable reports failures; MuJoCo would also write warnings into a file of the working directory.
mujoco.set_mju_user_warning(lambda _text: None)


class Unstable(Exception):
    """The simulation has produced values that are not finite; the text says when and which."""


@dataclass(frozen=True)
class Inertial:
    """The reading of an inertial sensor in the pelvis, in its own frame: rad/s, and m/s² with gravity."""

    turn_rate: tuple[float, float, float]
    acceleration: tuple[float, float, float]


@dataclass
class Push:
    """A force on the pelvis for some ticks, in N along the world's axes."""

    force: tuple[float, float, float]
    ticks: int


class World:
    """One robot on a floor. The same seed and the same calls between ticks give bit for bit the same result.

    `controllers` are called at the beginning of each tick, with the world's time in s; they call `aim` and
    `wish`. The only outside force on the robot is that of `push`.
    """

    def __init__(
        self,
        urdf: str,
        home: Mapping[str, float] | None = None,
        seed: int = 0,
        noise: Noise = USUAL,
        change: Callable[[Any], None] | None = None,
        walker: Callable[[Robot, float, Pose2D], Walker] = DcmWalker,
        around: Callable[[Any], None] | None = None,
    ) -> None:
        """`home` has the angles (rad) of joints that do not start at zero. Raises NotARobot.

        `change` may alter the simulated model (masses, friction); the walker keeps the unaltered model.
        `walker` makes the Walker from the unaltered robot, the s between two updates, and the robot's start
        pose. `around` adds the things of a world to the simulated model.
        """
        self._make_walker = walker
        self.robot: Robot = build(urdf, around=around)
        if change is not None:
            change(self.robot.model)
            mujoco.mj_setConst(self.robot.model, mujoco.MjData(self.robot.model))
        self._nominal = build(urdf)
        self.controllers: list[Callable[[float], None]] = []
        self.ticks = 0
        self.energy = 0.0  # J: work of the motors, braking counted as positive
        self.power = 0.0  # W: power of the motors during the last tick
        self.loads = (0.0, 0.0)  # N: loads on the left and the right sole
        self.fallen = False
        self._index = {name: index for index, name in enumerate(self.robot.names)}
        self._leg_joints = frozenset(int(joint) for leg in self.robot.legs for joint in leg.joints)
        self._data = mujoco.MjData(self.robot.model)
        self._others = np.setdiff1d(np.arange(len(self.robot.motors)), self.robot.balancing)
        self._legs = Legs(self._nominal)
        self._fastest = np.full(len(self.robot.names), np.inf)
        self._home = np.zeros(len(self.robot.names))
        self._sway = np.zeros(len(self.robot.names))
        for name, angle in (home or {}).items():
            self._home[self._index[name]] = angle
        self._senses = Senses(self.robot, self._data, noise, seed)
        self._push: Push | None = None
        self._chance = np.random.default_rng(seed)
        self._stand_up(Pose2D())
        for _ in range(SETTLE):
            self.tick()
        self.ticks, self.energy = 0, 0.0

    def _stand_up(self, at: Pose2D) -> None:
        """Place the robot at `at` on the floor, standing with its knees a little bent."""
        self.walker: Walker = self._make_walker(self._nominal, TICK / PERIODS, at)
        height = self.walker.height
        angles = self._legs.stand(height, self._home)
        self._goals, self._set_points = angles.copy(), angles
        others = np.ones(len(angles), dtype=bool)
        others[list(self._leg_joints)] = False
        mujoco.mj_resetData(self.robot.model, self._data)
        self._data.qpos[:7] = at.x, at.y, height, math.cos(at.yaw / 2.0), 0.0, 0.0, math.sin(at.yaw / 2.0)
        self._data.qpos[self.robot.qpos] = angles + others * self._chance.uniform(
            -SCATTER, SCATTER, len(angles)
        )
        mujoco.mj_forward(self.robot.model, self._data)
        self.fallen = False

    def arrange(self, move: Callable[[Any, Any], None]) -> None:
        """Call `move` with MuJoCo's model and data, to place the things around the robot."""
        move(self.robot.model, self._data)

    def get_up(self) -> None:
        """Place the robot upright where it lies: it cannot stand up by itself."""
        self._stand_up(self.true_pose)

    @property
    def time(self) -> float:
        """Seconds since the world began."""
        return self.ticks * TICK

    @property
    def estimate(self) -> Estimate:
        """The robot's estimate of itself, from its own sensors."""
        return self.walker.estimate

    @property
    def pose(self) -> Pose2D:
        """The pose of the pelvis on the floor, as the robot estimates it."""
        return self.walker.estimate.pose

    @property
    def velocity(self) -> Velocity2D:
        """The pelvis' velocity in its own frame, as the robot estimates it."""
        return self.walker.estimate.velocity

    @property
    def truth(self) -> Placement:
        """The true pose of the pelvis, for tests and for observers of the world."""
        return truth_of(self._data)

    @property
    def true_pose(self) -> Pose2D:
        """The true pose of the pelvis on the floor."""
        return self.truth.pose

    @property
    def pelvis_height(self) -> float:
        return float(self._data.qpos[2])

    @property
    def tilt(self) -> float:
        """How far the pelvis leans from upright, in rad."""
        return math.acos(min(max(float(read_rotation(self._data)[2, 2]), -1.0), 1.0))

    @property
    def outside_forces(self) -> tuple[Array, Array]:
        """The external forces on the bodies and on the degrees of freedom, without motors and floor."""
        return np.array(self._data.xfrc_applied), np.array(self._data.qfrc_applied)

    @property
    def torques(self) -> Array:
        """The torques of all motors in N·m (in N for sliding joints), in the order of `robot.motors`."""
        return np.array(self._data.actuator_force)

    @property
    def walking(self) -> bool:
        return self.walker.walking

    @property
    def inertial(self) -> Inertial:
        """The reading of the inertial sensor, with noise."""
        shown = self._senses.last
        turn, pull = shown.turn_rate.tolist(), shown.acceleration.tolist()
        return Inertial((turn[0], turn[1], turn[2]), (pull[0], pull[1], pull[2]))

    def joint(self, name: str) -> tuple[float, float, float]:
        """A joint's angle, speed and motor torque: rad, rad/s, N·m; for a sliding joint m, m/s, N."""
        index = self._index[name]
        dof = self.robot.dofs[index]
        return (
            float(self._data.qpos[self.robot.qpos[index]]),
            float(self._data.qvel[dof]),
            float(self._data.qfrc_actuator[dof]),
        )

    def sole(self, side: int) -> tuple[float, float, float]:
        """The position of the middle of the left (0) or the right (1) sole, in m, in the world's axes."""
        x, y, z = self._data.site_xpos[self.robot.legs[side].sole]
        return float(x), float(y), float(z)

    def touches(self) -> list[Touch]:
        """Return the robot's contacts with the world, but for those of its feet with the floor."""
        return find_touches(self.robot, self._data)

    def state(self) -> bytes:
        """All positions and velocities as bytes, to compare two simulations exactly."""
        return bytes(self._data.qpos.tobytes() + self._data.qvel.tobytes())

    def limit_speed(self, name: str, fastest: float) -> None:
        """Let a joint's set-point move no faster than `fastest` rad/s."""
        self._fastest[self._index[name]] = fastest

    def balances(self, name: str) -> bool:
        """Return True if a joint belongs to a leg: the legs keep the balance."""
        return self._index[name] in self._leg_joints

    def aim(self, name: str, angle: float) -> None:
        """Set a joint's goal angle, in rad. For joints of the legs this is ignored: they keep the balance."""
        if not self.balances(name):
            self._goals[self._index[name]] = angle

    def goal(self, name: str) -> float:
        """Return the joint's goal angle, set by `aim`, in rad."""
        return float(self._goals[self._index[name]])

    def sway(self, name: str, angle: float) -> None:
        """Add an angle in rad to a joint's set-point, beside its goal, until the next call."""
        if not self.balances(name):
            self._sway[self._index[name]] = angle

    def set_point(self, name: str) -> float:
        """Return the set-point of the joint's motor at this tick, in rad."""
        return float(self._set_points[self._index[name]])

    def hold(self, name: str) -> None:
        """Stop a joint at its present set-point."""
        self.aim(name, self.set_point(name))

    def wish(self, wish: Wish) -> None:
        """Pass the walker a wish: the velocity, and a place to stop at."""
        self.walker.wish(wish)

    def push(self, force: tuple[float, float, float], seconds: float) -> None:
        """Push the pelvis with a force (N, in the world's axes) for `seconds`, from the next tick on."""
        self._push = Push(force, max(round(seconds / TICK), 1))

    def tick(self) -> None:
        """Advance the simulation by TICK seconds. Raises Unstable."""
        for control in self.controllers:
            control(self.time)
        self._apply_push()
        before, wanted = self._set_points, self._goals + self._sway
        most = self._fastest * TICK
        self._set_points = before + np.minimum(np.maximum(wanted - before, -most), most)
        speeds = (self._set_points - before) / TICK
        for part in range(1, PERIODS + 1):
            self._command(before + (self._set_points - before) * (part / PERIODS), speeds)
            mujoco.mj_step(self.robot.model, self._data, STEPS)
        self.ticks += 1
        self._check()
        self._measure()

    def _command(self, set_points: Array, speeds: Array) -> None:
        """Give the balancing motors the walker's torques, and the others their set-points."""
        robot, data, others = self.robot, self._data, self._others
        if self.fallen:
            self._set_points = np.array(data.qpos[robot.qpos])
            self._goals = self._set_points.copy()
            give_way(robot, data, others)
            return
        if robot.waist is not None:
            self.walker.turn_waist(float(set_points[robot.waist]))
        torques = self.walker.update(self._senses.read())
        data.ctrl[robot.balancing] = torques[robot.balancing]
        joints = robot.motors[others]
        extra = (robot.damping[others] * speeds[joints] + torques[others]) / robot.stiffness[others]
        data.ctrl[others] = set_points[joints] + extra

    def _apply_push(self) -> None:
        force = self._data.xfrc_applied[1]
        force[:] = 0.0
        if self._push is not None:
            force[:3] = self._push.force
            self._push.ticks -= 1
            if self._push.ticks <= 0:
                self._push = None

    def _check(self) -> None:
        data = self._data
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            raise Unstable(f'after {self.time:.2f} s the state of the robot is not a number')
        self.fallen = self.fallen or has_fallen(self.pelvis_height, self.tilt)

    def _measure(self) -> None:
        robot, data = self.robot, self._data
        motors = robot.dofs[robot.motors]
        self.power = float(np.abs(data.qfrc_actuator[motors] * data.qvel[motors]).sum())
        self.energy += self.power * TICK
        self.loads = self._senses.loads()
