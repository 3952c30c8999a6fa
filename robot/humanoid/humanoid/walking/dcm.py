"""The divergent component of motion (DCM): the point to which a falling inverted pendulum moves.

The DCM is ξ = c + ċ/ω of the centre of mass c. It runs away from the point p on the floor where the ground
pushes: ξ̇ = ω (ξ - p). A plan of p for the steps ahead therefore fixes ξ, computed backwards from the end,
where ξ rests above p (Englsberger, Ott, Albu-Schäffer: Three-dimensional bipedal walking control based on
divergent component of motion, 2015).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from humanoid.walking.seam import Array


@dataclass(frozen=True)
class Segment:
    """The point where the floor pushes moves from `start` to `end` (m on the floor) at a constant speed."""

    duration: float  # s
    start: Array
    end: Array


def reference(segments: Sequence[Segment], elapsed: float, omega: float) -> tuple[Array, Array]:
    """Return ξ and p at `elapsed` s after the start of the first segment; the last one ends at rest."""
    dcm = segments[-1].end
    for segment in reversed(segments[1:]):
        dcm = _begin(segment, dcm, segment.duration, omega)
    first = segments[0]
    left = max(first.duration - elapsed, 0.0)
    share = min(elapsed / first.duration, 1.0) if first.duration > 0.0 else 1.0
    now = first.start + (first.end - first.start) * share
    return _begin(Segment(left, now, first.end), dcm, left, omega), now


def _begin(segment: Segment, at_end: Array, duration: float, omega: float) -> Array:
    """Return ξ at the start of a segment that ends with ξ at `at_end`."""
    if duration <= 0.0:
        return at_end
    decay = math.exp(-omega * duration)
    speed = (segment.end - segment.start) / duration / omega
    return segment.start + speed + (at_end - segment.end - speed) * decay
