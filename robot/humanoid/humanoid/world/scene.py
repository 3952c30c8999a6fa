"""The present state of a world: closed doors, people, and what scanner and camera see."""

from __future__ import annotations

import math

import numpy as np

from humanoid.model import BASE
from humanoid.navigation.base import Pose2D
from humanoid.world.file import WorldFile
from humanoid.world.people import Walker
from humanoid.world.solids import Array, Outlines, Solid

BEAMS = 360
LEAST_RANGE, GREATEST_RANGE = 0.1, 12.0  # m


class Scene:
    """A world whose doors open and close and whose people walk. Independent of ROS and of real time."""

    def __init__(self, file: WorldFile) -> None:
        self.file = file
        self.open = {door.name: door.is_open for door in file.doors}
        self.walkers = [Walker(person) for person in file.people]
        self._static = Outlines(file.solids)
        self._by_height: dict[float, Outlines] = {}

    @property
    def closed(self) -> list[Solid]:
        """The panels of the doors that are closed."""
        return [door.panel for door in self.file.doors if not self.open[door.name]]

    @property
    def moving(self) -> list[Solid]:
        """All solids that can move: the panels of closed doors, and people."""
        return [*self.closed, *(walker.solid for walker in self.walkers)]

    def step(self, elapsed: float, robot: Pose2D | None) -> None:
        """Let people walk for `elapsed` s; they stop for the robot, for closed doors and for each other."""
        for walker in self.walkers:
            others = Outlines([*self.closed, *(w.solid for w in self.walkers if w is not walker)])
            radius = walker.person.radius

            def room(x: float, y: float, others: Outlines = others, radius: float = radius) -> float:
                left = float(others.distance(np.array([[x, y]]))[0]) - radius
                if robot is None:
                    return left
                return min(left, math.hypot(x - robot.x, y - robot.y) - radius - BASE.radius)

            walker.step(elapsed, room)

    def can_close(self, door: str, robot: Pose2D | None) -> bool:
        """Return True if neither a person nor the robot stands in the gap of a door."""
        panel = next(each.panel for each in self.file.doors if each.name == door)
        outline = Outlines([panel])
        people = [(np.array([[w.x, w.y]]), w.person.radius) for w in self.walkers]
        if robot is not None:
            people.append((np.array([[robot.x, robot.y]]), BASE.radius))
        return all(float(outline.distance(place)[0]) > radius for place, radius in people)

    def clearance(self, robot: Pose2D) -> float:
        """Return the m from the robot's outline, a disc, to the nearest thing; 0 or less if they touch."""
        place = np.array([[robot.x, robot.y]])
        nearest = min(self._static.distance(place)[0], Outlines(self.moving).distance(place)[0])
        return float(nearest) - BASE.radius

    def scan(self, laser: Pose2D, height: float, noise: float, chance: np.random.Generator) -> Array:
        """Return the ranges of a scanner `height` m above the floor: in m, from angle -π on, inf for nothing.

        `noise` is the standard deviation of a range, in m.
        """
        angles = laser.yaw + beam_angles()
        seen = [solid for solid in self.moving if solid.height > height]
        reach = np.minimum(
            self._tall(height).cast(laser.x, laser.y, angles), Outlines(seen).cast(laser.x, laser.y, angles)
        )
        reach = reach + chance.normal(0.0, noise, BEAMS)
        ranges: Array = np.where((reach >= LEAST_RANGE) & (reach <= GREATEST_RANGE), reach, np.inf)
        return ranges

    def depths(self, eye: Array, rays: Array) -> Array:
        """Return how far each ray (n, 3) from `eye` (m) reaches, in multiples of its length; inf: no hit."""
        return np.minimum(
            self._static.cast_in_space(eye, rays), Outlines(self.moving).cast_in_space(eye, rays)
        )

    def _tall(self, height: float) -> Outlines:
        """Return the fixed things that reach a height, rounded to cm: so a swaying scanner reuses results."""
        key = round(height, 2)
        if key not in self._by_height:
            self._by_height[key] = Outlines([solid for solid in self.file.solids if solid.height > key])
        return self._by_height[key]


def beam_angles() -> Array:
    """Return the directions of the beams in the scanner's own frame, in rad."""
    return np.asarray(-np.pi + np.arange(BEAMS) * (2.0 * np.pi / BEAMS), dtype=np.float64)
