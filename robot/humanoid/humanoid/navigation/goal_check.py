"""Which navigation goals are refused, and why."""

from __future__ import annotations

import math
from collections.abc import Iterable

FRAME = 'odom'


def refusal(
    frame: str,
    position: tuple[float, float, float],
    orientation: tuple[float, float, float, float],
    timeout: float,
) -> str | None:
    """Why the goal cannot be taken, or None. Metres, a quaternion (x, y, z, w), seconds."""
    if frame not in ('', FRAME):
        return f'frame_id {frame!r} is unknown to the base; use {FRAME!r} or leave it empty'
    if not _finite(position):
        return f'position {position} is not finite'
    if not _finite(orientation):
        return f'orientation {orientation} is not finite'
    if position[2] < 0:
        return f'target z {position[2]} m is below the floor'
    if not (math.isfinite(timeout) and timeout > 0):
        return f'timeout {timeout} s is not a positive, finite time'
    return None


def _finite(numbers: Iterable[float]) -> bool:
    return all(math.isfinite(number) for number in numbers)
