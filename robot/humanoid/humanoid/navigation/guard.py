"""The guard of the base in a world: whatever asks it to move, it does not walk into what its scanner sees."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from humanoid.clock import seconds
from humanoid.model import BASE, DESCRIPTION
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D

MARGIN = 0.03  # m between the robot's outline and what it may come near to
AHEAD = (0.1, 0.2, 0.3, 0.45, 0.6)  # s at which the way ahead is looked at: the last covers braking
SHARES = (1.0, 0.7, 0.4, 0.2, 0.1)  # of the velocity that are tried
OLDEST = 0.5  # s: an older scan says nothing of what is there now
REMEMBERED = 50  # poses of the base, so that a scan is placed where it was taken

Points = NDArray[np.float64]


class Guard:
    """Knows the last scan, and how much of a velocity is safe. It needs no map."""

    def __init__(self) -> None:
        at = DESCRIPTION.pose('laser', {}).translation
        self._laser = at[0], at[1]
        self._poses: deque[tuple[float, Pose2D]] = deque(maxlen=REMEMBERED)
        self._points: Points | None = None  # in the frame that the poses are in
        self._taken = -math.inf

    def note_pose(self, moment: float, pose: Pose2D) -> None:
        """Remember where the base is; `moment` in s of the node's clock."""
        self._poses.append((moment, pose))

    def hear(self, scan: LaserScan) -> None:
        """Take a new scan, in the frame `laser`."""
        if not self._poses:
            return
        taken = seconds(scan.header.stamp)
        _, pose = min(self._poses, key=lambda each: abs(each[0] - taken))
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        angles = scan.angle_min + np.arange(len(ranges)) * scan.angle_increment
        near = np.isfinite(ranges)
        x = self._laser[0] + ranges[near] * np.cos(angles[near])
        y = self._laser[1] + ranges[near] * np.sin(angles[near])
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        self._points = np.stack([pose.x + cos * x - sin * y, pose.y + sin * x + cos * y], axis=1)
        self._taken = taken

    def limit(self, wish: Velocity2D, pose: Pose2D, moment: float) -> Velocity2D:
        """As much of a velocity as is safe. Turning on the spot always is, for the outline is a disc.

        Without a scan of the last 0.5 s nothing is.
        """
        if self._points is None or not -OLDEST <= moment - self._taken <= OLDEST:
            return STANDING
        if not len(self._points) or (wish.x == wish.y == 0.0):
            return wish
        reach = BASE.radius + MARGIN
        now = self._nearest(pose.x, pose.y)
        for share in SHARES:
            vx, vy = wish.x * share, wish.y * share
            ways = [self._nearest(*_place(pose, vx, vy, wish.yaw, after)) for after in AHEAD]
            if min(ways) >= reach or (now < reach and min(ways) >= now - 1e-3 and ways[-1] > now):
                return Velocity2D(vx, vy, wish.yaw)
        return Velocity2D(0.0, 0.0, wish.yaw)

    def _nearest(self, x: float, y: float) -> float:
        assert self._points is not None
        offset = self._points - [x, y]
        return float(np.sqrt((offset**2).sum(axis=1).min()))


def _place(pose: Pose2D, vx: float, vy: float, turn: float, after: float) -> tuple[float, float]:
    """Where the base is after some seconds, on the chord of its arc."""
    yaw = pose.yaw + turn * after / 2.0
    cos, sin = math.cos(yaw), math.sin(yaw)
    return pose.x + (cos * vx - sin * vy) * after, pose.y + (sin * vx + cos * vy) * after
