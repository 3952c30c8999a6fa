"""Decides when and where a foot steps: the phases of standing and walking, without masses and motors.

The DCM is the point to which the body moves (humanoid.walking.dcm). The wished steps give a plan of the DCM.
If the DCM is off its plan, the soles correct it; if they cannot, the foot in the air comes down elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from humanoid.navigation.base import STANDING, Pose2D
from humanoid.walking.dcm import Segment, reference
from humanoid.walking.footsteps import in_frame, middle_of, next_place, seen_from, within_reach
from humanoid.walking.seam import Array, Wish
from humanoid.walking.swing import Swing

SHIFT = 0.02  # s between two steps, in which both feet stand, and no foot can meet a push
SWING = 0.36  # s that a foot is in the air
HURRIED = 0.28  # s that a foot is in the air in a step that catches a fall
SHORTEST = 0.22  # s that a foot is in the air at least
FIRST_SHIFT = 0.5  # s for the weight to shift to one foot before a walk, and to both after it
GAIN = 3.0  # 1/s: how fast an error of the DCM decays
LENGTH, WIDTH = 0.10, 0.042  # m: half of a sole's usable length and width
TRUNK = 0.05  # m: a swing of the trunk moves the floor's push this far beyond the soles
SPARED = 0.7  # share of a sole's size for correcting errors; larger errors move the step
AHEAD = 3  # number of steps that the plan looks ahead
BEARS = 100.0  # N: with more load, a foot's measured pose replaces its planned pose
TOUCHES, EARLIEST = 60.0, 0.6  # N on a foot, after this share of its swing: it has touched down early
LANDS = 15.0  # N on a foot, at the end of its swing: it has touched down
FIXED = 0.06  # s before touch-down in which a foot's target stays unchanged
FALLS = (0.07, 0.10)  # m ahead and aside: with the DCM farther off the middle, a standing body must step
OFF = (0.025, 0.04)  # m and rad: a body farther than this from its wished place walks there
UNEVEN = (0.03, 0.08)  # m and rad: feet farther than this from standing side by side step
CALM = 0.04  # m: a walk may end if the error of the DCM is smaller


class Phase(Enum):
    STAND = 'stand'
    SHIFT = 'shift'  # the weight shifts to the foot that will bear it
    SWING = 'swing'
    SETTLE = 'settle'  # the weight shifts back to both feet


@dataclass(frozen=True)
class Seen:
    """The measurements that a gait needs: poses of the soles and the DCM on the floor (m), loads on the soles
    (N), and the inverted pendulum's rate `omega` (1/s).
    """

    feet: tuple[Pose2D, Pose2D]
    heights: tuple[float, float]  # m: heights of the soles above the floor
    loads: Array
    dcm: Array
    omega: float


class Gait:
    """Phases and footsteps of one body."""

    def __init__(self, feet: tuple[Pose2D, Pose2D]) -> None:
        self.wish = Wish()
        self.phase = Phase.STAND
        self.side = 0  # the foot that swings, or swings next: 0 left, 1 right
        self.swing: Swing | None = None
        self.target = feet[0]
        self.steps = 0
        self.error = np.zeros(2)  # m: the DCM minus its plan
        self._feet = list(feet)
        self._elapsed = 0.0  # s since the phase began
        self._duration = 0.0
        self._from = np.zeros(2)  # where the floor pushed when the weight began to shift

    @property
    def bearing(self) -> Sequence[int]:
        """The feet that carry the body."""
        return (1 - self.side,) if self.phase is Phase.SWING else (0, 1)

    @property
    def heading(self) -> float:
        """The heading that the pelvis should have, in rad."""
        stance = self._feet[1 - self.side]
        if self.swing is None:
            return self._middle.yaw
        return middle_of(stance, Pose2D(yaw=float(self.swing.place[2]))).yaw

    @property
    def _middle(self) -> Pose2D:
        return middle_of(*self._feet)

    def update(self, seen: Seen, elapsed: float) -> Array:
        """Let `elapsed` s pass; return where the floor should push now, in m."""
        for side in self.bearing:  # a foot may have slipped
            if seen.loads[side] > BEARS:
                self._feet[side] = seen.feet[side]
        self._elapsed += elapsed
        self._go_on(seen)
        wanted, point = reference(self._plan(), self._elapsed, seen.omega)
        self.error = seen.dcm - wanted
        if self.swing is not None:
            if self.swing.left > FIXED:
                self._adjust(self.swing, seen.omega, elapsed)
            self.swing.advance(elapsed, self.target)
        return self._within_soles(point + (1.0 + GAIN / seen.omega) * self.error)

    def _go_on(self, seen: Seen) -> None:
        over = self._elapsed >= self._duration
        if self.phase is Phase.STAND:
            self._leave_stand(seen)
        elif self.phase is Phase.SHIFT and over:
            self._lift(seen, HURRIED if np.abs(self.error).max() > CALM else SWING)
        elif self.phase is Phase.SETTLE and (over or self._falls(seen)):
            self._enter(Phase.STAND)
        elif self.swing is not None:
            load, share = seen.loads[self.side], self.swing.share
            if (share >= 1.0 and load > LANDS) or (share > EARLIEST and load > TOUCHES):
                self._land(seen)

    def _enter(self, phase: Phase, duration: float = 0.0) -> None:
        self.phase, self._elapsed, self._duration = phase, 0.0, duration

    def _leave_stand(self, seen: Seen) -> None:
        """Begin to walk, if there is a reason to."""
        if self._falls(seen):
            off = in_frame(seen.dcm - _spot(self._middle), self._middle.yaw)
            self.side = 0 if off[1] < 0.0 else 1  # the foot with less load
            self._shift(SHIFT)
        elif self._wants_to_step():
            speed = self.wish.velocity
            self.side = 0 if speed.y > 0.0 or speed.yaw > 0.0 else 1
            self._shift(FIRST_SHIFT)

    def _falls(self, seen: Seen) -> bool:
        middle = self._middle
        off = in_frame(seen.dcm - _spot(middle), middle.yaw)
        return bool(abs(off[0]) > FALLS[0] or abs(off[1]) > FALLS[1])

    def _wants_to_step(self) -> bool:
        wish, middle = self.wish, self._middle
        if wish.place is not None:
            left = seen_from(middle, wish.place)
            if math.hypot(left.x, left.y) > OFF[0] or abs(left.yaw) > OFF[1]:
                return True
        elif wish.velocity != STANDING:
            return True
        left_foot, right_foot = self._feet
        even = next_place(right_foot, 0, Wish(), 0.0)
        off = seen_from(even, left_foot)
        return math.hypot(off.x, off.y) > UNEVEN[0] or abs(off.yaw) > UNEVEN[1]

    def _shift(self, duration: float) -> None:
        self._from = _spot(self._middle)
        self.target = self._next(self._feet[1 - self.side], self.side)
        self._enter(Phase.SHIFT, duration)

    def _next(self, stance: Pose2D, side: int) -> Pose2D:
        return next_place(stance, side, self.wish, SHIFT + SWING)

    def _lift(self, seen: Seen, duration: float) -> None:
        side = self.side
        self.swing = Swing(seen.feet[side], max(seen.heights[side], 0.0), duration)
        self._enter(Phase.SWING, duration)

    def _land(self, seen: Seen) -> None:
        landed = self.side
        self._feet[landed] = seen.feet[landed]
        self._from = _spot(self._feet[1 - landed])
        self.swing, self.side = None, 1 - landed
        self.steps += 1
        self.target = self._next(self._feet[landed], self.side)
        if self._may_end():
            self._enter(Phase.SETTLE, FIRST_SHIFT)
        else:
            self._enter(Phase.SHIFT, SHIFT)

    def _may_end(self) -> bool:
        """Return True if the walk may end: a stop is wished, the next foot is in place, the body is calm."""
        off = seen_from(self._feet[self.side], self.target)
        there = math.hypot(off.x, off.y) < UNEVEN[0] and abs(off.yaw) < UNEVEN[1]
        stops = self.wish.place is not None or self.wish.velocity == STANDING
        return bool(there and stops and np.abs(self.error).max() < CALM)

    def _plan(self) -> Sequence[Segment]:
        """Return the planned points where the floor pushes, from the start of the present phase on."""
        middle, stance = _spot(self._middle), _spot(self._feet[1 - self.side])
        if self.phase is Phase.STAND:
            return [Segment(1.0, middle, middle)]
        if self.phase is Phase.SETTLE:
            return [Segment(self._duration, self._from, middle)]
        if self.phase is Phase.SHIFT:
            segments = [Segment(self._duration, self._from, stance), Segment(SWING, stance, stance)]
        else:
            lasts = max(self.swing.duration if self.swing is not None else SWING, self._elapsed)
            segments = [Segment(lasts, stance, stance)]
            if self.swing is None or self.swing.left > FIXED:
                self.target = self._next(self._feet[1 - self.side], self.side)
        before, place, side = stance, self.target, self.side
        for _ in range(AHEAD):
            spot = _spot(place)
            segments += [Segment(SHIFT, before, spot), Segment(SWING, spot, spot)]
            side = 1 - side
            before, place = spot, self._next(place, side)
        segments.append(Segment(SHIFT, before, (before + _spot(place)) / 2.0))
        return segments

    def _adjust(self, swing: Swing, omega: float, elapsed: float) -> None:
        """Shift the swinging foot's target by the error of the DCM that the standing sole cannot correct.

        All later steps and the plan shift with the target.
        """
        stance = self._feet[1 - self.side]
        growth = math.exp(omega * swing.left) * omega * SHIFT / (1.0 - math.exp(-omega * SHIFT))
        shift = in_frame(self.error, stance.yaw) * growth
        most = np.array((LENGTH, WIDTH)) * SPARED * (growth - 1.0)
        shift = in_frame(shift - np.clip(shift, -most, most), -stance.yaw)
        planned = self.target
        wanted = Pose2D(planned.x + float(shift[0]), planned.y + float(shift[1]), planned.yaw)
        self.target = within_reach(wanted, stance, self.side)
        made = _spot(self.target) - _spot(planned)
        missing = float(np.abs(shift - made).max())
        if missing > CALM and swing.duration > SHORTEST:
            swing.hurry(elapsed)
        self.error = self.error - made / growth

    def _within_soles(self, push: Array) -> Array:
        """Return the point nearest to `push` where the floor can push: in the soles, or TRUNK m beyond."""
        yaw = self._feet[self.bearing[0]].yaw
        feet = [in_frame(_spot(self._feet[side]), yaw) for side in self.bearing]
        margin = np.array((LENGTH + TRUNK, WIDTH + TRUNK))
        least, most = np.min(feet, axis=0) - margin, np.max(feet, axis=0) + margin
        return in_frame(np.clip(in_frame(push, yaw), least, most), -yaw)


def _spot(pose: Pose2D) -> Array:
    return np.array((pose.x, pose.y))
