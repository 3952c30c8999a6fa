"""Which navigation goals are refused, and why."""

from __future__ import annotations

from collections.abc import Iterable

from humanoid.text import quote

FRAME = 'odom'
FARTHEST = 1000.0  # m: a target may be this far from the origin, along each axis
LONGEST = 86400.0  # s: a day
GREATEST_TURN = 1000.0  # limit of a quaternion's components, so that their squares stay finite


def refusal(
    frame: str,
    position: tuple[float, float, float],
    orientation: tuple[float, float, float, float],
    timeout: float,
) -> str | None:
    """Return why the goal is refused, or None. Position in m, quaternion (x, y, z, w), timeout in s."""
    if frame not in ('', FRAME):
        return f'frame_id {quote(frame)} is unknown to the base; use {FRAME!r} or leave it empty'
    if not _within(FARTHEST, position):
        return f'position {position} is not within {FARTHEST:g} m of the origin'
    if not _within(GREATEST_TURN, orientation):
        return f'orientation {orientation} is not a quaternion with components up to {GREATEST_TURN:g}'
    if position[2] < 0:
        return f'target z {position[2]} m is below the floor'
    if not 0.0 < timeout <= LONGEST:
        return f'timeout {timeout} s is not a time of more than 0, up to {LONGEST:g} s'
    return None


def _within(greatest: float, numbers: Iterable[float]) -> bool:
    """Return True if all numbers are within the limit; False if one is NaN."""
    return all(abs(number) <= greatest for number in numbers)
