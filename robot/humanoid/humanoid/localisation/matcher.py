"""Fits a scan into a map: finds the pose at which its points lie on the edges of occupied cells.

The map becomes a field of signed distances to the nearest edge. A pose is improved by Gauss-Newton steps on
the distances of the points; points far from any edge (people, closed doors) lose their weight. A prior holds
the pose in directions that the scan does not determine, such as along a bare corridor. Sources: Censi, "An
ICP variant using a point-to-line metric" (2008), and the likelihood fields in Thrun, Burgard and Fox,
"Probabilistic Robotics", 6.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from humanoid.maps import Array, Geometry
from humanoid.navigation.base import Pose2D, turn_between

FARTHEST = 1.0  # m: the largest distance to an edge that counts; farther points are treated alike
STEPS = 10
SCALE = 0.08  # m: at this distance from an edge a point has a quarter of its full weight
DEVIATION = 0.06  # m: standard deviation of a point, for errors of the scanner and of the map
FITS_WITHIN = 0.12  # m: a point within this distance of an edge fits
ENOUGH = 15  # points that a match needs at least
NARROW = (0.02, 0.02, 0.02)  # m, m, rad: how far odometry may be off between two scans
WIDE = (0.3, 0.3, 0.3)  # m, m, rad: how far off a pose from `initialpose` may be, after the search
SEARCH_WAY, SEARCH_TURN = 0.6, math.radians(30.0)  # m and rad: the search's range around a given pose


@dataclass(frozen=True)
class Match:
    """A pose, its covariance (3 x 3: m², m rad, rad²), and the share of the scan's points that fit."""

    pose: Pose2D
    covariance: Array
    fits: float


class Matcher:
    """Fits scans into one map."""

    def __init__(self, geometry: Geometry, occupied: NDArray[np.bool_]) -> None:
        self._geometry = geometry
        if occupied.any():
            outside = distance_transform_edt(~occupied)
            inside = distance_transform_edt(occupied)
            field = np.where(occupied, 0.5 - inside, outside - 0.5) * geometry.resolution
            self._field: Array = np.clip(field, -FARTHEST, FARTHEST)
        else:
            self._field = np.full(occupied.shape, FARTHEST)

    def refine(self, points: Array, guess: Pose2D, prior: tuple[float, float, float] = NARROW) -> Match:
        """Return the pose near `guess` at which the points (n, 2), given in the robot's frame, fit best.

        `prior`: standard deviations of the guess, in m, m and rad.
        """
        trust = np.diag([1.0 / deviation**2 for deviation in prior])
        start = np.array([guess.x, guess.y, guess.yaw])
        pose = start.copy()
        information = trust
        for _ in range(STEPS if len(points) >= ENOUGH else 0):
            placed, lever = _place(points, pose)
            distance, slope = self._look_up(placed)
            weight = (np.abs(distance) < FARTHEST) / (1.0 + (distance / SCALE) ** 2) ** 2 / DEVIATION**2
            rows = np.column_stack([slope, (slope * lever).sum(axis=1)])
            information = (rows * weight[:, None]).T @ rows + trust
            off = pose - start
            off[2] = turn_between(guess.yaw, float(pose[2]))
            step = np.linalg.solve(information, (rows * weight[:, None]).T @ distance + trust @ off)
            pose = pose - step
            if np.abs(step).max() < 1e-4:
                break
        found = Pose2D(float(pose[0]), float(pose[1]), math.remainder(float(pose[2]), math.tau))
        return Match(found, np.linalg.inv(information), self.share_that_fits(points, found))

    def search(self, points: Array, guess: Pose2D) -> Match:
        """Return the best pose within 0.6 m and 30° of `guess`: try a coarse grid of poses, then refine."""
        few = points[:: max(len(points) // 60, 1)]
        ways = np.arange(-SEARCH_WAY, SEARCH_WAY + 0.01, 0.1)
        best, best_score = guess, -math.inf
        for turn in np.arange(-SEARCH_TURN, SEARCH_TURN + 0.01, math.radians(5.0)):
            turned, _ = _place(few, np.array([0.0, 0.0, guess.yaw + turn]))
            offsets = np.stack(np.meshgrid(guess.x + ways, guess.y + ways), axis=-1).reshape(-1, 2)
            placed = (turned[None, :, :] + offsets[:, None, :]).reshape(-1, 2)
            distance, _ = self._look_up(placed)
            scores = np.maximum(1.0 - np.abs(distance) / 0.3, 0.0).reshape(len(offsets), -1).sum(axis=1)
            at = int(scores.argmax())
            if scores[at] > best_score:
                x, y = offsets[at]
                best, best_score = Pose2D(float(x), float(y), guess.yaw + float(turn)), float(scores[at])
        return self.refine(points, best, WIDE)

    def share_that_fits(self, points: Array, pose: Pose2D) -> float:
        """Return the share of the points that lie on an edge of the map; 0 without points."""
        if not len(points):
            return 0.0
        placed, _ = _place(points, np.array([pose.x, pose.y, pose.yaw]))
        distance, _ = self._look_up(placed)
        return float((np.abs(distance) <= FITS_WITHIN).mean())

    def _look_up(self, points: Array) -> tuple[Array, Array]:
        """Return each point's signed distance to an edge and that distance's gradient, interpolated."""
        geometry, field = self._geometry, self._field
        at = (points - [geometry.x, geometry.y]) / geometry.resolution - 0.5
        column = np.clip(at[:, 0], 0.0, geometry.columns - 1.001)
        row = np.clip(at[:, 1], 0.0, geometry.rows - 1.001)
        i, j = row.astype(np.intp), column.astype(np.intp)
        u, v = row - i, column - j
        low, high = field[i, j], field[i + 1, j]
        low_next, high_next = field[i, j + 1], field[i + 1, j + 1]
        below, above = low + (low_next - low) * v, high + (high_next - high) * v
        along_x = (low_next - low) * (1.0 - u) + (high_next - high) * u
        slope = np.stack([along_x, above - below], axis=1) / geometry.resolution
        return below + (above - below) * u, slope


def _place(points: Array, pose: Array) -> tuple[Array, Array]:
    """Return the points in the map's frame, and their derivatives with respect to the pose's angle."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned = points @ np.array([[cos, sin], [-sin, cos]])
    return turned + pose[:2], np.stack([-turned[:, 1], turned[:, 0]], axis=1)
