"""The base in physics: it speeds up and slows down, faces a long way, and its legs do the walking."""

from __future__ import annotations

import math

from humanoid.model import BASE, BaseSpec
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.physics.world import TICK, World

ACCELERATION = 2.0  # m/s²
TURN_ACCELERATION = 6.0  # rad/s²
SIDEWAYS = 0.25  # m/s
BACKWARDS = 0.4  # m/s
LONG_WAY = 0.6  # m: a base that goes farther turns to face the way first
NEAR = 0.25  # m: closer to its target it turns to the target's heading
WITHIN = 0.005  # m, of the target
TURNED_WITHIN = 0.01  # rad


class PhysicsBase:
    """Moves a world's base to one target at a time, or at a given velocity."""

    def __init__(self, world: World, spec: BaseSpec = BASE) -> None:
        self._world, self._spec = world, spec
        self._target: Pose2D | None = None
        self._asked = STANDING  # a velocity, where there is no target
        self._facing = False
        self._at = world.pose  # where it should be now, and how fast: m/s in the world
        self._vx = self._vy = self._turn = 0.0
        world.controllers.append(self._control)

    @property
    def pose(self) -> Pose2D:
        return self._world.pose

    @property
    def height(self) -> float:
        return self._world.pelvis_height

    @property
    def velocity(self) -> Velocity2D:
        return self._world.velocity

    @property
    def arrived(self) -> bool:
        target = self._target
        return (
            target is not None
            and self._at == target
            and self.distance_to(target) <= WITHIN
            and abs(turn_between(self.pose.yaw, target.yaw)) <= TURNED_WITHIN
        )

    def drive_to(self, target: Pose2D) -> None:
        self._target = target
        self._facing = self.distance_to(target) > LONG_WAY

    def drive_at(self, velocity: Velocity2D) -> None:
        """Move at a velocity in the base's own frame, until told otherwise."""
        self._target, self._asked = None, velocity

    def stop(self) -> None:
        """Slow down to a stand."""
        self._target, self._asked = None, STANDING

    def distance_to(self, target: Pose2D) -> float:
        pose = self.pose
        return math.hypot(target.x - pose.x, target.y - pose.y)

    def step(self, elapsed: float) -> None:
        """Nothing: the world moves the base."""

    def _control(self, _time: float) -> None:
        vx, vy, turn = self._wish()
        speeds_up = ACCELERATION * TICK
        dx, dy = vx - self._vx, vy - self._vy
        share = min(1.0, speeds_up / max(math.hypot(dx, dy), 1e-12))
        self._vx, self._vy = self._vx + dx * share, self._vy + dy * share
        most = TURN_ACCELERATION * TICK
        self._turn += min(max(turn - self._turn, -most), most)
        at = self._at
        self._at = Pose2D(
            at.x + self._vx * TICK,
            at.y + self._vy * TICK,
            math.remainder(at.yaw + self._turn * TICK, math.tau),
        )
        target = self._target
        if target is not None and self._comes_to(target):
            self._at, self._vx, self._vy, self._turn = target, 0.0, 0.0, 0.0
        cos, sin = math.cos(self._at.yaw), math.sin(self._at.yaw)
        self._world.drive(
            self._at, Velocity2D(cos * self._vx + sin * self._vy, cos * self._vy - sin * self._vx, self._turn)
        )

    def _comes_to(self, target: Pose2D) -> bool:
        return (
            math.hypot(target.x - self._at.x, target.y - self._at.y) < 0.001
            and math.hypot(self._vx, self._vy) < 0.1
            and abs(turn_between(self._at.yaw, target.yaw)) < 0.002
            and abs(self._turn) < 0.3
        )

    def _wish(self) -> tuple[float, float, float]:
        """The velocity to come to, m/s in the world and rad/s."""
        at, target, spec = self._at, self._target, self._spec
        cos, sin = math.cos(at.yaw), math.sin(at.yaw)
        if target is None:
            forward, left = _walkable(self._asked.x, self._asked.y, spec.max_speed)
            turn = min(max(self._asked.yaw, -spec.max_turn_rate), spec.max_turn_rate)
        else:
            dx, dy = target.x - at.x, target.y - at.y
            distance = math.hypot(dx, dy)
            self._facing = self._facing and distance > NEAR
            off = turn_between(at.yaw, math.atan2(dy, dx) if self._facing else target.yaw)
            turn = math.copysign(_braking(abs(off), TURN_ACCELERATION, spec.max_turn_rate), off)
            speed = _braking(distance, ACCELERATION, spec.max_speed)
            if self._facing:
                speed *= max(math.cos(off), 0.0) ** 2
            way = math.atan2(dy, dx) - at.yaw
            forward, left = _walkable(speed * math.cos(way), speed * math.sin(way), spec.max_speed)
        return cos * forward - sin * left, sin * forward + cos * left, turn


def _braking(way: float, slows_down: float, fastest: float) -> float:
    """The speed at which `way` is enough to stop."""
    return min(fastest, math.sqrt(1.6 * slows_down * way), way / TICK)


def _walkable(forward: float, left: float, fastest: float) -> tuple[float, float]:
    """The velocity, or as much of it in the same direction as legs can do."""
    share = min(
        1.0,
        fastest / max(math.hypot(forward, left), 1e-12),
        SIDEWAYS / max(abs(left), 1e-12),
        BACKWARDS / max(-forward, 1e-12),
    )
    return forward * share, left * share
