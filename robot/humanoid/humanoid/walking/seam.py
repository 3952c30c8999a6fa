"""The interface between a body and its walker: sensor readings in, motor torques out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from humanoid.navigation.base import STANDING, Pose2D, Velocity2D

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sensed:
    """The sensors' readings at one moment. No sensor measures where on the floor the body is."""

    turn_rate: Array  # rad/s: rotation rates of the pelvis, in its own frame
    acceleration: Array  # m/s²: of the pelvis in its own frame, gravity included
    angles: Array  # rad (m if prismatic): positions of all movable joints, in the URDF's order
    speeds: Array  # rad/s (m/s)
    loads: Array  # N: loads on the left and the right sole


@dataclass(frozen=True)
class Wish:
    """How the body shall walk: a velocity in its own frame, and a place to stop at once it is near."""

    velocity: Velocity2D = STANDING
    place: Pose2D | None = None


@dataclass(frozen=True)
class Estimate:
    """A walker's estimate of its body: where the pelvis is and how it moves, in m, rad and s."""

    pose: Pose2D
    velocity: Velocity2D  # in the body's own frame
    height: float
    roll: float
    pitch: float


class Walker(Protocol):
    """Keeps one body upright and lets it walk. All calls come from one thread.

    `DcmWalker` computes the torques by physical models; a learned policy can be a Walker, too.
    """

    period: float  # s between two calls of `update`
    height: float  # m: height of the pelvis above the floor while standing

    @property
    def estimate(self) -> Estimate:
        """The estimate of the last update."""

    @property
    def walking(self) -> bool:
        """True while the body walks; False while it stands at rest on both feet."""

    def wish(self, wish: Wish) -> None:
        """Walk as `wish` says, from the next step on, until the next wish."""

    def turn_waist(self, angle: float) -> None:
        """Turn the trunk to an angle in rad, as far as the balance allows."""

    def update(self, sensed: Sensed) -> Array:
        """Return the torques (N·m) of all motors for the next period.

        The motors of legs and waist give these torques. The other motors follow set-points; their torque here
        is added, to carry the weight of their links. It may be zero.
        """
