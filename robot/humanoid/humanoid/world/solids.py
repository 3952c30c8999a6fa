"""The things of a world as upright blocks and pillars, and distances to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Colour = tuple[float, float, float]  # red, green, blue, each from 0 to 1


@dataclass(frozen=True)
class Block:
    """An upright box on the floor: its centre (m), heading (rad), length, width and height (m)."""

    kind: str
    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    height: float
    colour: Colour

    def corners(self) -> Array:
        """The four corners on the floor, counter-clockwise: an array of shape (4, 2), in m."""
        across = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [self.length / 2.0, self.width / 2.0]
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        turned: Array = across @ np.array([[cos, sin], [-sin, cos]]) + [self.x, self.y]
        return turned


@dataclass(frozen=True)
class Pillar:
    """An upright cylinder that stands on the floor, in m."""

    kind: str
    name: str
    x: float
    y: float
    radius: float
    height: float
    colour: Colour


Solid = Block | Pillar


class Outlines:
    """Solids as arrays, so that many rays and distances are computed at once. Immutable."""

    def __init__(self, solids: Sequence[Solid]) -> None:
        blocks = [each for each in solids if isinstance(each, Block)]
        pillars = [each for each in solids if isinstance(each, Pillar)]
        self._frames = np.array([(b.x, b.y, math.cos(b.yaw), math.sin(b.yaw)) for b in blocks]).reshape(-1, 4)
        self._heights = np.array([b.height for b in blocks])
        self._round_heights = np.array([p.height for p in pillars])
        self._halves = np.array([(b.length / 2.0, b.width / 2.0) for b in blocks]).reshape(-1, 2)
        corners = np.array([b.corners() for b in blocks]).reshape(-1, 4, 2)
        self._starts = corners.reshape(-1, 2)
        self._edges = (np.roll(corners, -1, axis=1) - corners).reshape(-1, 2)
        self._rounds = np.array([(p.x, p.y, p.radius) for p in pillars]).reshape(-1, 3)

    def distance(self, points: Array) -> Array:
        """Return the m from each point (n, 2) to the nearest solid: 0 inside a solid, inf without solids."""
        nearest = np.full(len(points), np.inf)
        if len(self._frames):
            offset = points[:, None, :] - self._frames[None, :, :2]
            cos, sin = self._frames[:, 2], self._frames[:, 3]
            along = np.abs(offset[..., 0] * cos + offset[..., 1] * sin) - self._halves[:, 0]
            across = np.abs(offset[..., 1] * cos - offset[..., 0] * sin) - self._halves[:, 1]
            apart = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
            nearest = np.minimum(nearest, apart.min(axis=1))
        if len(self._rounds):
            offset = points[:, None, :] - self._rounds[None, :, :2]
            apart = np.hypot(offset[..., 0], offset[..., 1]) - self._rounds[:, 2]
            nearest = np.minimum(nearest, np.maximum(apart.min(axis=1), 0.0))
        return nearest

    def cast(self, x: float, y: float, angles: Array) -> Array:
        """Return the m from (x, y) to the first solid in each direction of `angles` (rad), inf for none."""
        rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        reach = np.full(len(angles), np.inf)
        if len(self._starts):
            reach = np.minimum(reach, self._cast_at_edges(x, y, rays))
        if len(self._rounds):
            reach = np.minimum(reach, self._cast_at_rounds(x, y, rays))
        return reach

    def cast_in_space(self, start: Array, rays: Array) -> Array:
        """Return the distance along each ray (n, 3) from `start` (3,) to the first solid or the floor.

        Distances are multiples of the ray's length; inf if the ray meets nothing.
        """
        with np.errstate(divide='ignore', invalid='ignore'):
            reach = np.where(rays[:, 2] < 0.0, -start[2] / rays[:, 2], np.inf)
            if len(self._frames):
                reach = np.minimum(reach, self._cast_at_boxes(start, rays))
            if len(self._rounds):
                reach = np.minimum(reach, self._cast_at_cylinders(start, rays))
        return reach

    def _cast_at_boxes(self, start: Array, rays: Array) -> Array:
        """Cast rays at boxes: a ray is in a box while it is between opposite faces, for all three pairs."""
        cos, sin = self._frames[:, 2], self._frames[:, 3]
        offset = start[:2] - self._frames[:, :2]
        begins = np.full((len(rays), len(cos)), 0.0)
        ends = np.full((len(rays), len(cos)), np.inf)
        x, y, z = rays[:, :1], rays[:, 1:2], rays[:, 2:]
        half = self._heights / 2.0
        sides = (
            (offset[:, 0] * cos + offset[:, 1] * sin, x * cos + y * sin, self._halves[:, 0]),
            (offset[:, 1] * cos - offset[:, 0] * sin, y * cos - x * sin, self._halves[:, 1]),
            (start[2] - half, np.broadcast_to(z, begins.shape), half),
        )
        for at, along, half in sides:
            one, other = (-half - at) / along, (half - at) / along
            begins = np.fmax(begins, np.fmin(one, other))
            ends = np.fmin(ends, np.fmax(one, other))
        reach: Array = np.where(begins <= ends, begins, np.inf).min(axis=1)
        return reach

    def _cast_at_cylinders(self, start: Array, rays: Array) -> Array:
        """Cast rays at the round sides of cylinders; their tops are ignored."""
        offset = start[:2] - self._rounds[:, :2]
        a = (rays[:, :2] ** 2).sum(axis=1)[:, None]
        b = rays[:, :1] * offset[:, 0] + rays[:, 1:2] * offset[:, 1]
        c = (offset**2).sum(axis=1) - self._rounds[:, 2] ** 2
        t = (-b - np.sqrt(b**2 - a * c)) / a
        z = start[2] + t * rays[:, 2:]
        hits = (t >= 0.0) & (z >= 0.0) & (z <= self._round_heights)  # False where NaN
        reach: Array = np.where(hits, t, np.inf).min(axis=1)
        return reach

    def _cast_at_edges(self, x: float, y: float, rays: Array) -> Array:
        """Cast rays at edges: the ray o + t r meets the edge p + u e at t = cross(p - o, e) / cross(r, e).

        For u, the dividend is cross(p - o, r).
        """
        start, edge = self._starts - [x, y], self._edges
        parallel = rays[:, :1] * edge[:, 1] - rays[:, 1:] * edge[:, 0]
        parallel = np.where(np.abs(parallel) < 1e-12, np.nan, parallel)
        t = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / parallel
        u = (start[:, 0] * rays[:, 1:] - start[:, 1] * rays[:, :1]) / parallel
        hits = (t >= 0.0) & (u >= 0.0) & (u <= 1.0)  # False where NaN
        reach: Array = np.where(hits, t, np.inf).min(axis=1)
        return reach

    def _cast_at_rounds(self, x: float, y: float, rays: Array) -> Array:
        centre = self._rounds[:, :2] - [x, y]
        along = rays @ centre.T
        aside = rays[:, :1] * centre[:, 1] - rays[:, 1:] * centre[:, 0]
        radius = self._rounds[:, 2]
        inside = radius**2 - aside**2
        t = along - np.sqrt(np.maximum(inside, 0.0))
        reach: Array = np.where((inside >= 0.0) & (t >= 0.0), t, np.inf).min(axis=1)
        return reach
