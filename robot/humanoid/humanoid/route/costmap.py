"""Obstacles from the map and the latest scans together, as clearances (distances) and as costs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from humanoid.maps import Array, Geometry
from humanoid.model import BASE
from humanoid.navigation.base import Pose2D

KEEPS = BASE.radius + 0.08  # m between the robot's centre and obstacles on a planned path: it sways by 3 cm
FADES = 0.8  # m: with this clearance or more, a cell's cost is 0
LETHAL, STEEPEST = 100, 90  # costs, 0 to 100: of an impassable cell, and the highest of a passable cell
STEEPNESS = 5.0  # 1/m
CLEARED_TO = 8.0  # m: to this distance a beam clears the cells that it crosses
KNOWN_WITHIN = 0.12  # m: scanned points within this distance of a mapped obstacle belong to it
FORGOTTEN_AFTER = 30.0  # s for which an obstacle out of sight is remembered
STAYS_WITHIN = 2.5  # m: an obstacle that was only seen from farther away may have gone when the robot comes


class Costmap:
    """The clearance of each cell, updated with each scan. All times are in s of the same steady clock."""

    def __init__(self, geometry: Geometry, occupied: NDArray[np.bool_]) -> None:
        self.geometry = geometry
        self._seen_at = np.full(occupied.shape, -math.inf)
        self._seen = np.zeros(occupied.shape, dtype=bool)  # the obstacles that only scans have shown
        self._seen_near = np.zeros(occupied.shape, dtype=bool)  # those of them that were seen from near
        self.mapped = _clearance(occupied, geometry.resolution)
        self.clearance = self.mapped
        """The distance in m from each cell's centre to the nearest obstacle of the map or of a scan."""

    def see(self, laser: Pose2D, angles: Array, ranges: Array, now: float) -> None:
        """Take a scan: `angles` (rad) in the scanner's frame, `ranges` in m, inf if nothing is near."""
        self._clear(laser, angles, ranges)
        met = np.isfinite(ranges)
        angles = angles[met] + laser.yaw
        rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._mark([laser.x, laser.y] + rays * ranges[met][:, None], ranges[met] <= STAYS_WITHIN, now)
        self._renew(now)

    def _clear(self, laser: Pose2D, angles: Array, ranges: Array) -> None:
        """Forget obstacles in cells that a beam has crossed."""
        seen = np.argwhere(np.isfinite(self._seen_at))
        offset = self.geometry.centres(seen) - [laser.x, laser.y]
        apart = np.hypot(offset[:, 0], offset[:, 1])
        turn = (np.arctan2(offset[:, 1], offset[:, 0]) - laser.yaw - angles[0]) % math.tau
        beam = np.rint(turn / (angles[1] - angles[0])).astype(np.intp) % len(angles)
        over = (ranges[beam] > apart + 2.0 * self.geometry.resolution) & (apart < CLEARED_TO)
        self._seen_at[seen[over, 0], seen[over, 1]] = -math.inf
        self._seen_near[seen[over, 0], seen[over, 1]] = False

    def forget(self) -> None:
        """Forget all scanned obstacles until the next scan: those out of sight may have gone."""
        self._seen_at.fill(-math.inf)
        self._seen_near[:] = False
        self._seen[:] = False
        self.clearance = self.mapped

    def forecast(self) -> Array:
        """Return the clearances without the scanned obstacles that were only seen from far away."""
        return self._lower(self._seen & self._seen_near)

    def clearance_at(self, points: Array) -> Array:
        """Return the clearance at each point (n, 2), in m; 0 off the map."""
        return self._at(self.clearance, points)

    def measure_mapped(self, points: Array) -> Array:
        """Return the clearance at each point by the map only, without the scans."""
        return self._at(self.mapped, points)

    def costs(self) -> NDArray[np.int8]:
        """Return the costs, from 0 to 100, as in an OccupancyGrid."""
        return costs_of(self.clearance)

    def window(self, x: float, y: float, half: float) -> tuple[Geometry, NDArray[np.int8]]:
        """Return the geometry and the costs of the square with sides of 2 x `half` m around (x, y)."""
        whole = self.geometry
        reach = math.ceil(half / whole.resolution)
        row, column = (int(each) for each in whole.cells(np.array([[x, y]]))[0])
        top, left = max(row - reach, 0), max(column - reach, 0)
        part = self.clearance[top : max(row + reach, 1), left : max(column + reach, 1)]
        x, y = whole.x + left * whole.resolution, whole.y + top * whole.resolution
        return Geometry(x, y, whole.resolution, *part.shape), costs_of(part)

    def _mark(self, points: Array, near: NDArray[np.bool_], now: float) -> None:
        cells = self.geometry.cells(points)
        inside = self.geometry.inside(cells)
        cells, near = cells[inside], near[inside]
        self._seen_at[cells[:, 0], cells[:, 1]] = now
        self._seen_near[cells[near, 0], cells[near, 1]] = True

    def _renew(self, now: float) -> None:
        self._seen = (now - self._seen_at <= FORGOTTEN_AFTER) & (self.mapped > KNOWN_WITHIN)
        self.clearance = self._lower(self._seen)

    def _lower(self, seen: NDArray[np.bool_]) -> Array:
        """Return the clearances of the map, lowered near the cells that are `seen`."""
        rows, columns = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return self.mapped
        reach = math.ceil(FADES / self.geometry.resolution)
        part = (
            slice(max(rows[0] - reach, 0), rows[-1] + reach + 1),
            slice(max(columns[0] - reach, 0), columns[-1] + reach + 1),
        )
        lowered: Array = self.mapped.copy()
        near = _clearance(seen[part], self.geometry.resolution)
        lowered[part] = np.minimum(self.mapped[part], near)
        return lowered

    def _at(self, field: Array, points: Array) -> Array:
        cells = self.geometry.cells(points)
        on = self.geometry.inside(cells)
        cells[~on] = 0
        found: Array = np.where(on, field[cells[:, 0], cells[:, 1]], 0.0)
        return found


def costs_of(clearance: Array) -> NDArray[np.int8]:
    """Return the cost for each clearance (m): 100 where the robot would be too near, falling from there."""
    falling = STEEPEST * np.exp(-STEEPNESS * (clearance - KEEPS))
    costs = np.where(clearance < FADES, falling, 0.0)
    return np.where(clearance < KEEPS, LETHAL, costs).astype(np.int8)


def _clearance(occupied: NDArray[np.bool_], resolution: float) -> Array:
    """Return the distance, in m, from each cell's centre to the edge of the nearest occupied cell."""
    if not occupied.any():
        return np.full(occupied.shape, 100.0)
    found: Array = np.maximum(distance_transform_edt(~occupied) - 0.5, 0.0) * resolution
    return found
