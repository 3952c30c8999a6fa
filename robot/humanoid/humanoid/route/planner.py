"""Plans the shortest path over a costmap's cells, with distance to obstacles where there is room.

Dijkstra's algorithm (scipy.sparse.csgraph) runs from the goal over cells with eight neighbours. Then the
path is pulled tight: bends that a straight line can replace are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from humanoid.maps import Array, Cells, Flags, Geometry
from humanoid.navigation.base import Pose2D
from humanoid.route.costmap import KEEPS, costs_of

DEAR = 3.0  # a path through cells with cost 100 counts as longer by this factor
OFF_BY = 0.35  # m: a robot too near to an obstacle starts at the nearest free cell, at most this far
SPACING = 0.1  # m between two points of a path


class NoWay(Exception):
    """There is no way from the start to the goal; the text says why."""


def plan(geometry: Geometry, clearance: Array, start: Pose2D, goal: Pose2D) -> Array:
    """Return the path from start to goal: points (n, 2) in m, 0.1 m apart, with both ends. Raises NoWay."""
    free = clearance >= KEEPS
    here, there = _cell(geometry, start), _cell(geometry, goal)
    for cell, pose, what in ((here, start, 'the robot'), (there, goal, 'the goal')):
        if not geometry.inside(np.array([cell]))[0]:
            raise NoWay(f'{what} is off the map, at ({pose.x:.2f}, {pose.y:.2f}) m')
    if not free[there]:
        raise NoWay(f'the goal ({goal.x:.2f}, {goal.y:.2f}) m is too near to something, or within it')
    if not free[here]:
        here = _nearest_free(geometry, free, start)
    cells = _walk(geometry, free, clearance, here, there)
    points = geometry.centres(cells)
    points[-1] = goal.x, goal.y
    points[0] = start.x, start.y
    return space(_pull_tight(geometry, clearance, points))


def points_of(poses: Sequence[Pose2D]) -> Array:
    """Return the places of poses as points (n, 2), in m."""
    return np.array([[pose.x, pose.y] for pose in poses], dtype=np.float64).reshape(-1, 2)


def length(path: Array) -> float:
    """Return the length of a path, in m."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def _cell(geometry: Geometry, pose: Pose2D) -> tuple[int, int]:
    row, column = geometry.cells(np.array([[pose.x, pose.y]]))[0]
    return int(row), int(column)


def _nearest_free(geometry: Geometry, free: Flags, start: Pose2D) -> tuple[int, int]:
    cells = np.argwhere(free)
    if len(cells):
        apart = np.hypot(*(geometry.centres(cells) - [start.x, start.y]).T)
        best = int(apart.argmin())
        if apart[best] <= OFF_BY:
            return int(cells[best][0]), int(cells[best][1])
    raise NoWay(f'the robot stands too near to something, at ({start.x:.2f}, {start.y:.2f}) m')


def _walk(
    geometry: Geometry, free: Flags, clearance: Array, here: tuple[int, int], there: tuple[int, int]
) -> Cells:
    """Return the cheapest sequence of free cells from `here` to `there`. Raises NoWay."""
    number = np.full(free.shape, -1)
    number[free] = np.arange(int(free.sum()))
    factor = 1.0 + DEAR * costs_of(clearance) / 100.0
    starts, ends, weights = [], [], []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        one = (slice(0, geometry.rows - down), slice(max(-right, 0), geometry.columns - max(right, 0)))
        other = (slice(down, geometry.rows), slice(max(right, 0), geometry.columns - max(-right, 0)))
        both = free[one] & free[other]
        starts.append(number[one][both])
        ends.append(number[other][both])
        weights.append((factor[one][both] + factor[other][both]) / 2.0 * math.hypot(down, right))
    count = int(free.sum())
    edges = (np.concatenate(weights), (np.concatenate(starts), np.concatenate(ends)))
    graph = csr_matrix(edges, shape=(count, count))
    _, before = dijkstra(graph, directed=False, indices=number[there], return_predecessors=True)
    cells, at, goal = np.argwhere(free), int(number[here]), int(number[there])
    if at != goal and before[at] < 0:
        raise NoWay('no way leads there')
    way = [at]
    while at != goal:
        at = int(before[at])
        way.append(at)
    found: Cells = cells[way if len(way) > 1 else way * 2]
    return found


def _pull_tight(geometry: Geometry, clearance: Array, points: Array) -> Array:
    """Leave out points where a straight line comes no nearer to obstacles than the path itself."""
    kept, at = [0], 0
    own = _sample(geometry, clearance, points)
    while at < len(points) - 1:
        reach = len(points) - 1
        while reach > at + 1 and not _is_as_good(geometry, clearance, points, own, at, reach):
            reach = at + max((reach - at) // 2, 1)
        kept.append(reach)
        at = reach
    tight: Array = points[kept]
    return tight


def _is_as_good(
    geometry: Geometry, clearance: Array, points: Array, own: Array, first: int, last: int
) -> bool:
    count = max(math.ceil(np.hypot(*(points[last] - points[first])) / geometry.resolution), 1)
    line = points[first] + np.linspace(0.0, 1.0, count + 1)[:, None] * (points[last] - points[first])
    least = min(float(own[first : last + 1].min()), 0.6)
    return bool((_sample(geometry, clearance, line) >= least - 1e-6).all())


def _sample(geometry: Geometry, clearance: Array, points: Array) -> Array:
    cells = np.clip(geometry.cells(points), 0, [geometry.rows - 1, geometry.columns - 1])
    found: Array = clearance[cells[:, 0], cells[:, 1]]
    return found


def space(points: Array) -> Array:
    """Return points at most 0.1 m apart along the line through the points (n, 2), with both ends.

    There are at least two of them, also if all given points lie in one place.
    """
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.linspace(0.0, ways[-1], max(math.ceil(ways[-1] / SPACING), 1) + 1)
    return np.stack([np.interp(at, ways, points[:, 0]), np.interp(at, ways, points[:, 1])], axis=1)
