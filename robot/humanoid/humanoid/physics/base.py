"""The base in physics: it gives the walker velocities, faces a distant target, and stops at the target."""

from __future__ import annotations

import math

from humanoid.goal_endings import GoalFailed
from humanoid.model import BaseSpec
from humanoid.navigation.base import STANDING, Placement, Pose2D, Velocity2D, turn_between
from humanoid.physics.world import TICK, World
from humanoid.walking.names import FELL
from humanoid.walking.seam import Wish

ACCELERATION, BRAKES = 0.5, 1.0  # m/s²
TURN_ACCELERATION = 2.0  # rad/s²
SIDEWAYS = 0.2  # m/s
BACKWARDS = 0.3  # m/s
WALKS = BaseSpec(max_speed=0.5, max_turn_rate=0.6)  # a faster robot often falls: docs/how-to/physics.md
LONG_WAY = 1.5  # m: if the target is farther, the base first turns to face it
NEAR = 0.3  # m: within this distance of the target, the base turns to the target's heading
WITHIN = 0.04  # m: within this distance of the target, the base has arrived
TURNED_WITHIN = 0.06  # rad


class PhysicsBase:
    """Walks a world's robot to one target at a time, or at a given velocity."""

    def __init__(self, world: World, spec: BaseSpec = WALKS) -> None:
        self._world, self._spec = world, spec
        self._target: Pose2D | None = None
        self._asked = STANDING  # the velocity to keep while there is no target
        self._facing = False
        self._now = STANDING  # the velocity that the walker has now been given
        world.controllers.append(self._control)

    @property
    def pose(self) -> Pose2D:
        return self._world.pose

    @property
    def truth(self) -> Placement:
        return self._world.truth

    @property
    def height(self) -> float:
        return self._world.estimate.height

    @property
    def tilt(self) -> tuple[float, float]:
        estimate = self._world.estimate
        return estimate.roll, estimate.pitch

    @property
    def velocity(self) -> Velocity2D:
        return self._world.velocity

    @property
    def arrived(self) -> bool:
        target = self._target
        return (
            target is not None
            and not self._world.walking
            and self.distance_to(target) <= WITHIN
            and abs(turn_between(self.pose.yaw, target.yaw)) <= TURNED_WITHIN
        )

    def drive_to(self, target: Pose2D) -> None:
        self._target = target
        self._facing = self.distance_to(target) > LONG_WAY

    def drive_at(self, velocity: Velocity2D) -> None:
        """Move at a velocity in the base's own frame, until the next command."""
        self._target, self._asked = None, velocity

    def limit(self, velocity: Velocity2D) -> Velocity2D:
        """Return the velocity that the legs can walk if `velocity` is asked for: slower, on the same arc.

        An arc that is walked wider than asked would lead into the post of a door.
        """
        share = min(
            _walkable_share(velocity.x, velocity.y, self._spec.max_speed),
            self._spec.max_turn_rate / max(abs(velocity.yaw), 1e-12),
        )
        return Velocity2D(velocity.x * share, velocity.y * share, velocity.yaw * share)

    def stop(self) -> None:
        """Slow down and stand."""
        self._target, self._asked = None, STANDING

    def distance_to(self, target: Pose2D) -> float:
        pose = self.pose
        return math.hypot(target.x - pose.x, target.y - pose.y)

    def step(self, _elapsed: float) -> None:
        """Do nothing: the world moves the base. Raises GoalFailed if the robot has fallen on its way."""
        if self._world.fallen and (self._target is not None or self._asked != STANDING):
            self.stop()
            raise GoalFailed(FELL)

    def _control(self, _time: float) -> None:
        wished, now = self._wished(), self._now
        self._now = Velocity2D(
            _towards(now.x, wished.x, ACCELERATION, BRAKES),
            _towards(now.y, wished.y, ACCELERATION, BRAKES),
            _towards(now.yaw, wished.yaw, TURN_ACCELERATION, TURN_ACCELERATION),
        )
        self._world.wish(Wish(self._now, self._target))

    def _wished(self) -> Velocity2D:
        """Return the velocity to accelerate to, in the base's own frame."""
        pose, target, spec = self.pose, self._target, self._spec
        if target is None:
            return self.limit(self._asked)
        distance = self.distance_to(target)
        self._facing = self._facing and distance > NEAR
        way = math.atan2(target.y - pose.y, target.x - pose.x)
        off = turn_between(pose.yaw, way if self._facing else target.yaw)
        turn = math.copysign(_braking(abs(off), TURN_ACCELERATION, spec.max_turn_rate), off)
        speed = _braking(distance, ACCELERATION, spec.max_speed)
        if self._facing:
            speed *= max(math.cos(off), 0.0) ** 2
        forward, left = speed * math.cos(way - pose.yaw), speed * math.sin(way - pose.yaw)
        share = _walkable_share(forward, left, spec.max_speed)
        return Velocity2D(forward * share, left * share, turn)


def _towards(now: float, wished: float, speeds_up: float, slows_down: float) -> float:
    """Return the speed after a tick, which changes by so much in a second at most."""
    most = (slows_down if abs(wished) < abs(now) else speeds_up) * TICK
    return now + min(max(wished - now, -most), most)


def _braking(way: float, slows_down: float, fastest: float) -> float:
    """Return the highest speed from which the base can stop within the distance `way`."""
    return min(fastest, math.sqrt(1.2 * slows_down * way))


def _walkable_share(forward: float, left: float, fastest: float) -> float:
    """Return the share of a velocity that the legs can walk."""
    return min(
        1.0,
        fastest / max(math.hypot(forward, left), 1e-12),
        SIDEWAYS / max(abs(left), 1e-12),
        BACKWARDS / max(-forward, 1e-12),
    )
