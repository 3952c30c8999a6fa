"""One arm motion: its progress, and when it has ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from humanoid.model import JOINT_BY_NAME

PATIENCE = 1.0  # s after the goal's duration in which the joints may still arrive


@dataclass(frozen=True)
class ArmMotion:
    """A motion from `start` to `target` (rad, or m) that began at `began` (s of the node's clock)."""

    names: Sequence[str]
    start: Sequence[float]
    target: Sequence[float]
    duration: float
    began: float

    def fraction_done(self, here: Mapping[str, float]) -> float:
        """Return the progress, 0 to 1, of the joint with the longest way, measured in tolerances."""
        ways = [abs(end - begin) for begin, end in zip(self.start, self.target, strict=True)]
        in_tolerances = [way / within for way, within in zip(ways, self._within, strict=True)]
        if max(in_tolerances) <= 1.0:
            return 1.0
        longest = in_tolerances.index(max(in_tolerances))
        return min(max(1.0 - self._off(here)[longest] / ways[longest], 0.0), 1.0)

    def arrived(self, here: Mapping[str, float]) -> bool:
        return all(off <= within for off, within in zip(self._off(here), self._within, strict=True))

    def failure(self, here: Mapping[str, float], seen: float) -> str | None:
        """Return why the motion has failed, or None; at `seen` (s) the joints' positions were `here`."""
        if seen - self.began > self.duration + PATIENCE:
            short = ', '.join(
                f'{name} by {off:.3f} {JOINT_BY_NAME[name].unit}'
                for name, off in zip(self.names, self._off(here), strict=True)
            )
            return f'{PATIENCE:.0f} s past the duration of {self.duration} s it is still off: {short}'
        return None

    @property
    def _within(self) -> Sequence[float]:
        """How close to its target each joint must come, in rad or m."""
        return [JOINT_BY_NAME[name].arrived_within for name in self.names]

    def _off(self, here: Mapping[str, float]) -> Sequence[float]:
        """Return how far each joint is from its target, in rad or m."""
        return [abs(end - here[name]) for name, end in zip(self.names, self.target, strict=True)]
