"""Makes a path smoother, and keeps it clear of obstacles.

The smooth path minimises the sum of the squared distances to the given path and of the squared curvature
(Whittaker, 1923, on a line instead of a table). If a stretch of it comes nearer to an obstacle than the given
path allows, its points are bound more tightly to the given path, and the sum is minimised again. In the end
such a stretch is the given path itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import spsolve

from humanoid.maps import Array
from humanoid.route.costmap import KEEPS, Costmap

BENDS_OVER = 0.4  # m: about the length over which a sharp corner is rounded
SPACING = 0.1  # m between two points of the smooth path, at most
APART = 1e-3  # m between two points, at least: nearer ones are left out
ROOMY = KEEPS + 0.08  # m: a path that has this clearance everywhere may come nearer to obstacles
TIGHTER = 10.0  # the factor by which points near obstacles are bound more tightly in each round
BOUND = 1e6  # times the usual weight, from which a point stays where it was given
BESIDE = 2  # points on both sides of such a point that are bound with it
ROUNDS = 20  # at most; after them the given path is the result
LEAST = 3  # points, with fewer of which there is nothing to smooth


@dataclass(frozen=True)
class Smoothed:
    """A smooth path: points (n, 2) in m; `is_complete` is False if time ran out before it was as meant."""

    points: Array
    is_complete: bool


def smooth(costmap: Costmap, points: Array, is_late: Callable[[], bool]) -> Smoothed:
    """Smooth the line through points (n, 2) on the map, in m; its ends stay where they are.

    `is_late` says if the time for it is over; the result is then the given path.
    """
    given = densify(points)
    if len(given) < LEAST:
        return Smoothed(given, is_complete=True)
    bend, usual = _bending(given), _measure_shares(given)
    bound = np.ones(len(given))
    bound[[0, -1]] = BOUND
    room = np.minimum(_clearances(costmap, given), ROOMY)
    for _ in range(ROUNDS):
        if is_late():
            return Smoothed(given, is_complete=False)
        found: Array = spsolve(csc_matrix(bend + diags(bound * usual)), (bound * usual)[:, None] * given)
        found[bound >= BOUND] = given[bound >= BOUND]
        near = _clearances(costmap, found) < room
        if not near.any():
            return Smoothed(found, is_complete=True)
        bound[binary_dilation(near, iterations=BESIDE)] *= TIGHTER
    return Smoothed(given, is_complete=True)


def find_collision(costmap: Costmap, points: Array, reach: float) -> tuple[float, float] | None:
    """Return the first place on the line where something is nearer than `reach` m; None if there is none."""
    line = densify(points, costmap.geometry.resolution)
    near = costmap.clearance_at(line) < reach
    if not near.any():
        return None
    x, y = line[int(near.argmax())]
    return float(x), float(y)


def densify(points: Array, spacing: float = SPACING) -> Array:
    """Return the points, at most `spacing` m apart: with more between them, and none twice in one place."""
    kept = [points[0]]
    for point in points[1:]:
        gap = math.hypot(*(point - kept[-1]))
        if gap < APART:
            continue
        count = math.ceil(gap / spacing - 1e-9)
        shares = np.arange(1, count + 1)[:, None] / count
        kept.extend(kept[-1] + shares * (point - kept[-1]))
    if len(kept) > 1:
        kept[-1] = points[-1]
    return np.array(kept)


def _bending(line: Array) -> csc_matrix:
    """Return the matrix (n, n) of the sum of squared curvature along the line, weighted for smoothing."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    before, after = steps[:-1], steps[1:]
    length = (before + after) / 2.0
    second = diags(
        [1.0 / (before * length), -(1.0 / before + 1.0 / after) / length, 1.0 / (after * length)],
        offsets=[0, 1, 2],
        shape=(len(line) - 2, len(line)),
    )
    weight = BENDS_OVER**4 * length / SPACING
    return csc_matrix(second.T @ diags(weight) @ second)


def _measure_shares(line: Array) -> Array:
    """Return the length of the line that each point stands for, in units of SPACING."""
    steps = np.concatenate([[0.0], np.hypot(*np.diff(line, axis=0).T), [0.0]])
    shares: Array = (steps[:-1] + steps[1:]) / (2.0 * SPACING)
    return shares


def _clearances(costmap: Costmap, line: Array) -> Array:
    """Return for each point the least clearance there and halfway to its neighbours, in m."""
    own = costmap.clearance_at(line)
    halfway = costmap.clearance_at((line[1:] + line[:-1]) / 2.0)
    own[1:] = np.minimum(own[1:], halfway)
    own[:-1] = np.minimum(own[:-1], halfway)
    return own
