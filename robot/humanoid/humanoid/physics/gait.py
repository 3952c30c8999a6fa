"""Where the feet go while the base moves: plain geometry, without physics.

One foot at a time swings from where it stood to where the base will need it; the other stands still on the
floor. A base that stands gets its feet back under it, and then nothing moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between

SWING = 0.3  # s that a foot is in the air
SHIFT = 0.06  # s that both feet stand between two steps, while the weight passes over
CLEARANCE = 0.06  # m that a foot is lifted at the middle of its way
OUT_OF_PLACE = 0.02  # m from its place under a standing base: beyond it the foot steps back there
TURNED_AWAY = 0.06  # rad, the same of its heading
SLOW = 0.01  # m/s and rad/s: a base slower than this stands


@dataclass(frozen=True)
class Foot:
    """A sole in the world: m, below its ankle; heading and pitch in rad, toes down positive.

    `load` is the part of the robot's weight that is meant for it.
    """

    x: float
    y: float
    z: float
    yaw: float
    pitch: float
    load: float


class Phase(Enum):
    STANDS = 'stands'
    SHIFTS = 'shifts'  # both feet on the floor, the weight passes to the one that will stand
    SWINGS = 'swings'


class Gait:
    """Steps for two feet that stand `half_width` m to the left and the right of the base."""

    def __init__(self, half_width: float, base: Pose2D) -> None:
        self._sides = (half_width, -half_width)
        self._planted = [self._place(base, side) for side in (0, 1)]
        self._loads = [0.5, 0.5]
        self._phase = Phase.STANDS
        self._elapsed = 0.0  # s since the phase began
        self._side = 0  # the foot that swings, or will next
        self._from = self._planted[0]
        self.steps = 0
        self.feet = (self._foot(base, STANDING, 0), self._foot(base, STANDING, 1))

    @property
    def walking(self) -> bool:
        """False once both feet stand where they should under a base that stands."""
        return self._phase is not Phase.STANDS

    def update(self, elapsed: float, base: Pose2D, velocity: Velocity2D) -> tuple[Foot, Foot]:
        """Let `elapsed` s pass; the base is at `base`, its `velocity` is in its own frame. The two feet."""
        self._elapsed += elapsed
        if self._phase is Phase.SWINGS and self._elapsed >= SWING:
            self._planted[self._side] = self._landing(base, velocity)
            self._side = 1 - self._side
            self.steps += 1
            self._enter(Phase.SHIFTS if self._must_step(base, velocity) else Phase.STANDS)
        elif self._phase is Phase.STANDS and self._must_step(base, velocity):
            self._enter(Phase.SHIFTS)
        elif self._phase is Phase.SHIFTS and self._elapsed >= SHIFT:
            self._from = self._planted[self._side]
            self._enter(Phase.SWINGS)
        self._shift_weight(elapsed)
        self.feet = (self._foot(base, velocity, 0), self._foot(base, velocity, 1))
        return self.feet

    def _enter(self, phase: Phase) -> None:
        self._phase, self._elapsed = phase, 0.0

    def _must_step(self, base: Pose2D, velocity: Velocity2D) -> bool:
        """Whether there is a next step; a base that stands picks the foot that is out of its place."""
        if math.hypot(velocity.x, velocity.y) > SLOW or abs(velocity.yaw) > SLOW:
            return True
        if not self._off(base, self._side):
            if not self._off(base, 1 - self._side):
                return False
            self._side = 1 - self._side
        return True

    def _off(self, base: Pose2D, side: int) -> bool:
        place, foot = self._place(base, side), self._planted[side]
        return (
            math.hypot(place.x - foot.x, place.y - foot.y) > OUT_OF_PLACE
            or abs(turn_between(place.yaw, foot.yaw)) > TURNED_AWAY
        )

    def _place(self, base: Pose2D, side: int) -> Pose2D:
        """Where a foot belongs under a base that stands."""
        width = self._sides[side]
        return Pose2D(base.x - width * math.sin(base.yaw), base.y + width * math.cos(base.yaw), base.yaw)

    def _landing(self, base: Pose2D, velocity: Velocity2D) -> Pose2D:
        """Where the swinging foot comes down: as far ahead of the base as it will leave behind it."""
        left = max(SWING - self._elapsed, 0.0)
        stands = SWING + 2.0 * SHIFT
        return self._place(moved(base, velocity, left + stands / 2.0), self._side)

    def _foot(self, base: Pose2D, velocity: Velocity2D, side: int) -> Foot:
        if self._phase is not Phase.SWINGS or side != self._side:
            foot = self._planted[side]
            return Foot(foot.x, foot.y, 0.0, foot.yaw, 0.0, self._loads[side])
        share = min(self._elapsed / SWING, 1.0)
        start, end = self._from, self._landing(base, velocity)
        way = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)  # starts and ends at rest
        return Foot(
            start.x + (end.x - start.x) * way,
            start.y + (end.y - start.y) * way,
            CLEARANCE * math.sin(math.pi * share) ** 2,
            start.yaw + turn_between(start.yaw, end.yaw) * way,
            0.0,
            self._loads[side],
        )

    def _shift_weight(self, elapsed: float) -> None:
        """The foot that swings, or will, gets rid of its load in time; standing feet share it."""
        for side in (0, 1):
            wanted = 0.5 if self._phase is Phase.STANDS else float(side != self._side)
            most = elapsed / SHIFT
            self._loads[side] += min(max(wanted - self._loads[side], -most), most)


def moved(base: Pose2D, velocity: Velocity2D, elapsed: float) -> Pose2D:
    """Where a base is after `elapsed` s at a velocity in its own frame, the turn included."""
    middle = base.yaw + velocity.yaw * elapsed / 2.0
    cos, sin = math.cos(middle), math.sin(middle)
    return Pose2D(
        base.x + (cos * velocity.x - sin * velocity.y) * elapsed,
        base.y + (sin * velocity.x + cos * velocity.y) * elapsed,
        base.yaw + velocity.yaw * elapsed,
    )
