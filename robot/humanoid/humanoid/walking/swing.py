"""The path of a foot through the air, to a target that may still change."""

from __future__ import annotations

import math

import numpy as np

from humanoid.navigation.base import Pose2D, turn_between
from humanoid.walking.seam import Array

CLEARANCE = 0.05  # m
NEAREST_END = 0.05  # s: the remaining time is never taken as shorter than this
DROPS = 0.2  # m/s: speed down of a foot that finds no floor at the expected height


class Swing:
    """A minimum-jerk path of a foot from its present pose to a target (m and rad), up and down on the way."""

    def __init__(self, start: Pose2D, height: float, duration: float) -> None:
        """`height`: the sole's height above the floor at the start, in m."""
        self.duration, self.elapsed = duration, 0.0
        self.place = np.array((start.x, start.y, start.yaw))
        self.speed, self.pull = np.zeros(3), np.zeros(3)
        self._lift = height

    @property
    def left(self) -> float:
        """The time in s until the foot should touch the floor."""
        return max(self.duration - self.elapsed, 0.0)

    @property
    def share(self) -> float:
        return self.elapsed / self.duration

    def hurry(self, seconds: float) -> None:
        """Touch down `seconds` sooner, or as much sooner as is possible."""
        self.duration = max(self.duration - seconds, self.elapsed + NEAREST_END)

    def advance(self, elapsed: float, target: Pose2D) -> None:
        self.elapsed += elapsed
        left = max(self.left, NEAREST_END)
        yaw = float(self.place[2])
        way = np.array((target.x, target.y, yaw + turn_between(yaw, target.yaw))) - self.place
        jerk = 60.0 * way / left**3 - 36.0 * self.speed / left**2 - 9.0 * self.pull / left
        self.pull = self.pull + jerk * elapsed
        self.speed = self.speed + self.pull * elapsed
        self.place = self.place + self.speed * elapsed

    def height(self) -> Array:
        """Return the sole's height above the floor, and its vertical speed and acceleration: m, m/s, m/s²."""
        late = self.elapsed - self.duration
        if late > 0.0:
            return np.array((-DROPS * late, -DROPS, 0.0))
        rate = 1.0 / self.duration
        angle = math.tau * self.share
        return np.array(
            (
                self._lift * (1.0 - self.share) + CLEARANCE * (1.0 - math.cos(angle)) / 2.0,
                CLEARANCE * math.pi * rate * math.sin(angle) - self._lift * rate,
                CLEARANCE * math.pi * math.tau * rate**2 * math.cos(angle),
            )
        )
