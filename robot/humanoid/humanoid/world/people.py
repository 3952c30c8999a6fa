"""People who walk along their paths and back. They stop for obstacles, and turn back after a while."""

from __future__ import annotations

import math
from collections.abc import Callable

from humanoid.world.file import Person
from humanoid.world.solids import Pillar

COLOUR = (0.86, 0.52, 0.25)
PATIENCE = 3.0  # s that a person waits before turning back
ROOM = 0.35  # m: a person stops at this distance from an obstacle ahead
BESIDE = 0.12  # m: a person keeps this distance from obstacles at the side


class Walker:
    """One walking person. `heading` is in rad, along the path."""

    def __init__(self, person: Person) -> None:
        self.person = person
        self.x, self.y = person.path[0]
        self.heading = 0.0
        self.walks = False
        self._next, self._by = 1, 1  # index of the path's next point, and its step: 1 or -1
        self._waited = 0.0

    @property
    def solid(self) -> Pillar:
        """This person as a pillar, at the present position."""
        one = self.person
        return Pillar('person', one.name, self.x, self.y, one.radius, one.height, COLOUR)

    def step(self, elapsed: float, room: Callable[[float, float], float]) -> None:
        """Walk for `elapsed` s. `room(x, y)`: m from this person at (x, y) to the nearest moving obstacle."""
        way, self.walks = self.person.speed * elapsed, False
        if way <= 0.0:
            return
        goal_x, goal_y = self.person.path[self._next]
        dx, dy = goal_x - self.x, goal_y - self.y
        left = math.hypot(dx, dy)
        if left <= way:
            self.x, self.y = goal_x, goal_y
            self._pass_on()
            return
        self.heading = math.atan2(dy, dx)
        ahead = way + ROOM
        next_x, next_y = self.x + dx / left * way, self.y + dy / left * way
        aside = room(next_x, next_y)
        if room(self.x + dx / left * ahead, self.y + dy / left * ahead) > 0.0 and (
            aside > BESIDE or aside > room(self.x, self.y)
        ):
            self.x, self.y = next_x, next_y
            self.walks, self._waited = True, 0.0
            return
        self._waited += elapsed
        if self._waited >= PATIENCE:
            self._waited, self._by = 0.0, -self._by
            self._next = min(max(self._next + self._by, 0), len(self.person.path) - 1)

    def _pass_on(self) -> None:
        """Choose the path's next point to walk to; at an end of the path, turn back."""
        if not 0 <= self._next + self._by < len(self.person.path):
            self._by = -self._by
        self._next += self._by
