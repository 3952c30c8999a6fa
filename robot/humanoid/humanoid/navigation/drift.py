"""Odometry that drifts: feet slide, so the error grows with the distance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from humanoid.navigation.base import Pose2D, turn_between

DRIFT = (0.02, 0.02, 0.01)  # the default drift of odometry in a world


@dataclass(frozen=True)
class DriftSpec:
    """The size of odometry's errors; if all are zero, odometry is exact."""

    way: float = 0.0  # share of the distance that odometry counts too much
    turn: float = 0.0  # share of each turn that odometry counts too much
    veer: float = 0.0  # error of the heading, in rad for each m of distance

    @property
    def none(self) -> bool:
        return self.way == self.turn == self.veer == 0.0


class Drift:
    """Computes the drifting pose of odometry from the true pose."""

    def __init__(self, spec: DriftSpec, pose: Pose2D) -> None:
        self._spec = spec
        self._true = self.pose = pose

    def follow(self, true: Pose2D) -> Pose2D:
        """Add the motion since the last call, with its errors, and return the pose by odometry."""
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
