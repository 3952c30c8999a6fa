"""Odometry that drifts: feet slide, so a robot's own count of its way goes wrong bit by bit."""

from __future__ import annotations

import math
from dataclasses import dataclass

from humanoid.navigation.base import Pose2D, turn_between

DRIFT = (0.02, 0.02, 0.01)  # of the odometry in a world, if nothing else is asked for


@dataclass(frozen=True)
class DriftSpec:
    """How wrong the count goes. Zeros: not at all."""

    way: float = 0.0  # share of the way that is counted too much
    turn: float = 0.0  # share of each turn that is counted too much
    veer: float = 0.0  # rad that the heading goes wrong in each m of the way

    @property
    def none(self) -> bool:
        return self.way == self.turn == self.veer == 0.0


class Drift:
    """The pose that the robot believes in, beside the one that it has."""

    def __init__(self, spec: DriftSpec, pose: Pose2D) -> None:
        self._spec = spec
        self._true = self.pose = pose

    def follow(self, true: Pose2D) -> Pose2D:
        """Count the motion since the last call, as wrong as it may be; the pose that this comes to."""
        if self._spec.none:
            self._true = self.pose = true
            return true
        before, self._true = self._true, true
        dx, dy, turn = true.x - before.x, true.y - before.y, turn_between(before.yaw, true.yaw)
        way = math.hypot(dx, dy)
        counted = way * (1.0 + self._spec.way)
        direction = self.pose.yaw + math.atan2(dy, dx) - before.yaw
        yaw = self.pose.yaw + turn * (1.0 + self._spec.turn) + way * self._spec.veer
        self.pose = Pose2D(
            self.pose.x + counted * math.cos(direction),
            self.pose.y + counted * math.sin(direction),
            math.remainder(yaw, math.tau),
        )
        return self.pose
