"""The guard of the base in a world: it limits velocities, so that the base hits nothing that a scan shows."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import LaserScan

from humanoid.clock import seconds
from humanoid.model import BASE, DESCRIPTION
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D

MARGIN = 0.05  # m between the robot's outline and obstacles at least
AHEAD = (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)  # s ahead that are checked; legs need the last to stop
SHARES = (1.0, 0.7, 0.4, 0.2, 0.1)  # shares of the wanted velocity, tried in this order
OLDEST = 0.5  # s: an older scan is not used
REMEMBERED = 50  # number of past poses kept: a scan is placed at the pose where it was taken

Points = NDArray[np.float64]


class Guard:
    """Decides, by the last scan and without a map, how much of a velocity is safe."""

    def __init__(self) -> None:
        at = DESCRIPTION.pose('laser', {}).translation
        self._laser = at[0], at[1]
        self._poses: deque[tuple[float, Pose2D]] = deque(maxlen=REMEMBERED)
        self._points: Points | None = None  # the last scan's points, in the frame of the poses
        self._taken = -math.inf

    def note_pose(self, moment: float, pose: Pose2D) -> None:
        """Remember where the base is; `moment` in s of the node's clock."""
        self._poses.append((moment, pose))

    def hear(self, scan: LaserScan) -> None:
        """Take a new scan, and place its points by the base's pose at the scan's time."""
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
        """Return the safe part of a velocity. Turning on the spot is always safe: the outline is a disc.

        Without a scan of the last 0.5 s no motion counts as safe.
        """
        if self._points is None or not -OLDEST <= moment - self._taken <= OLDEST:
            return STANDING
        if not len(self._points):
            return wish
        return slow_down(wish, pose, BASE.radius + MARGIN, self._measure)

    def _measure(self, places: Points) -> Points:
        """Return the distance of each place (n, 2) to the nearest point of the scan."""
        assert self._points is not None
        offset = self._points[None, :, :] - places[:, None, :]
        nearest: Points = np.sqrt((offset**2).sum(axis=2).min(axis=1))
        return nearest


def slow_down(
    wish: Velocity2D, pose: Pose2D, reach: float, measure: Callable[[Points], Points]
) -> Velocity2D:
    """Return the part of a velocity that keeps `reach` m clear of everything, or leads away from it.

    `measure` returns the clearance at each of the places (n, 2), in m. Turning on the spot is always safe.
    """
    if wish.x == wish.y == 0.0:
        return wish
    now = float(measure(np.array([[pose.x, pose.y]]))[0])
    for share in SHARES:
        vx, vy = wish.x * share, wish.y * share
        ways = measure(np.array([_place(pose, vx, vy, wish.yaw, after) for after in AHEAD]))
        least = ways.min()
        if least >= reach or (now < reach and least >= now - 1e-3 and ways[-1] > now):
            return Velocity2D(vx, vy, wish.yaw)
    return Velocity2D(0.0, 0.0, wish.yaw)


def _place(pose: Pose2D, vx: float, vy: float, turn: float, after: float) -> tuple[float, float]:
    """Return where the base is `after` seconds at a velocity; an arc is replaced by its chord."""
    yaw = pose.yaw + turn * after / 2.0
    cos, sin = math.cos(yaw), math.sin(yaw)
    return pose.x + (cos * vx - sin * vy) * after, pose.y + (sin * vx + cos * vy) * after
