"""The robot's own walker: it estimates the state, plans steps by the DCM, and computes the torques."""

from __future__ import annotations

import math

import numpy as np

from humanoid.navigation.base import STANDING, Pose2D, Velocity2D
from humanoid.physics.build import Robot
from humanoid.walking.balance import Balance
from humanoid.walking.body import Body
from humanoid.walking.estimator import Estimator
from humanoid.walking.gait import Gait, Phase
from humanoid.walking.seam import Array, Estimate, Sensed, Wish

HEIGHT = 0.72  # m: height of the pelvis above the floor


class DcmWalker:
    """A Walker made of an estimator, a gait and a force control."""

    def __init__(self, robot: Robot, period: float, at: Pose2D, height: float = HEIGHT) -> None:
        """The robot starts standing upright at `at`, its pelvis `height` m above the floor."""
        self.period, self.height = period, height
        self._body = Body(robot)
        self._estimator = Estimator(self._body, period, np.array((at.x, at.y, height)), at.yaw)
        self._estimate = Estimate(at, STANDING, height, 0.0, 0.0)
        self._balance: Balance | None = None  # made at the first update: it needs a state
        self._wish, self._waist = Wish(), 0.0

    @property
    def estimate(self) -> Estimate:
        return self._estimate

    @property
    def gait(self) -> Gait | None:
        """The gait of the walker; None before the first update."""
        return None if self._balance is None else self._balance.gait

    @property
    def walking(self) -> bool:
        return self.gait is not None and self.gait.phase is not Phase.STAND

    def wish(self, wish: Wish) -> None:
        self._wish = wish

    def turn_waist(self, angle: float) -> None:
        self._waist = angle

    def update(self, sensed: Sensed) -> Array:
        self._estimator.update(sensed)
        if self._balance is None:
            self._balance = Balance(self._body, self.period, self.height)
        self._balance.wish(self._wish)
        self._balance.waist = self._waist
        torques = self._balance.torques(sensed.loads)
        self._estimate = estimate_of(self._body)
        robot = self._body.robot
        return np.asarray(torques[robot.dofs[robot.motors]])


def estimate_of(body: Body) -> Estimate:
    """Return the pose and the velocity of a body's pelvis, from the state that the body was set to."""
    turn, place = body.pelvis, body.position
    yaw = math.atan2(turn[1, 0], turn[0, 0])
    cos, sin = math.cos(yaw), math.sin(yaw)
    vx, vy = float(body.speeds[0]), float(body.speeds[1])
    rate = float((turn @ body.speeds[3:6])[2])
    return Estimate(
        Pose2D(float(place[0]), float(place[1]), yaw),
        Velocity2D(cos * vx + sin * vy, cos * vy - sin * vx, rate),
        float(place[2]),
        math.atan2(turn[2, 1], turn[2, 2]),
        math.asin(min(max(-float(turn[2, 0]), -1.0), 1.0)),
    )
