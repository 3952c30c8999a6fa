"""The interface between joint_state_service and the joints, for reading their states and commanding them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from humanoid.joints.commands import Plan
from humanoid.model import MOVING_SPEED, JointSpec


@dataclass(frozen=True)
class JointSample:
    """Position, velocity and effort of one joint at one moment, in rad, rad/s and N·m (m, m/s and N)."""

    position: float
    velocity: float
    effort: float

    @property
    def is_moving(self) -> bool:
        return abs(self.velocity) > MOVING_SPEED

    @property
    def is_finite(self) -> bool:
        return all(map(math.isfinite, (self.position, self.velocity, self.effort)))


class JointSource(Protocol):
    """The joints of one robot: `KinematicJoints` simulates them, another class may drive real ones.

    To drive real joints, write a class with these four members around the motor bus and hand it to
    `JointStateService(source)`. All calls come from one thread, `update` 50 times a second; none may
    block for longer than a few milliseconds, so a slow bus needs a thread of its own behind this class.
    Times are seconds of the node's clock.
    """

    @property
    def joints(self) -> Mapping[str, JointSpec]:
        """The joints by name, in the order in which `joint_states` lists them."""

    def update(self, now: float) -> None:
        """Update the readings and the set-points for the time `now`."""

    def read(self, name: str) -> JointSample:
        """Return the joint's state at the last update."""

    def follow(self, plan: Plan, start: float) -> None:
        """Move the plan's joints through their waypoints, whose times count from `start` (s).

        A new plan replaces the old plan of the joints that it names. A joint without waypoints stops. Raises
        CommandRefused if one of the joints takes no commands.
        """


class NotANumber(ValueError):
    """A joint's reading is NaN or infinite; the text says which."""


def read_all(source: JointSource) -> Sequence[tuple[str, JointSample]]:
    """Read every joint, in the source's order. Raises NotANumber."""
    samples = {name: source.read(name) for name in source.joints}
    check_finite(samples)
    return list(samples.items())


def check_finite(samples: Mapping[str, JointSample]) -> None:
    """Raise NotANumber if a reading is NaN or infinite: it may not be published or used in commands."""
    for name, sample in samples.items():
        if not sample.is_finite:
            raise NotANumber(f'the reading of {name} is not a number: {sample}')
