"""The feet's targets: the middle between the feet moves as wished, and each foot stays on its own side."""

from __future__ import annotations

import math

import numpy as np

from humanoid.navigation.base import Pose2D, turn_between
from humanoid.walking.seam import Array, Wish

WIDTH = 0.18  # m between the middles of the two soles, side by side
FARTHEST = 0.5  # m: the longest step in front of or behind the other foot
WIDEST, NARROWEST = 0.55, 0.11  # m: limits of the distance beside the other foot; a sole is 0.10 m wide
MOST_TURN = 0.55  # rad: the largest angle between the two feet
NEAR = 0.3  # m: within this distance of the place to stop at, the steps lead to that place
LITTLE = (0.12, 0.12, 0.4)  # m ahead, m aside and rad: the largest step near the place to stop at
LEFT, RIGHT = 0, 1


def seen_from(pose: Pose2D, place: Pose2D) -> Pose2D:
    """Return `place`, expressed in the frame of `pose`."""
    ahead, left = in_frame(np.array((place.x - pose.x, place.y - pose.y)), pose.yaw)
    return Pose2D(float(ahead), float(left), turn_between(pose.yaw, place.yaw))


def in_frame(way: Array, yaw: float) -> Array:
    """Return a vector on the floor, expressed in a frame that is turned by `yaw` (rad)."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array((cos * way[0] + sin * way[1], cos * way[1] - sin * way[0]))


def move_pose(pose: Pose2D, ahead: float, left: float, turn: float = 0.0) -> Pose2D:
    """Return a pose after a displacement in its own frame (m) and a turn (rad)."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(
        pose.x + cos * ahead - sin * left,
        pose.y + sin * ahead + cos * left,
        math.remainder(pose.yaw + turn, math.tau),
    )


def middle_of(left: Pose2D, right: Pose2D) -> Pose2D:
    yaw = left.yaw + turn_between(left.yaw, right.yaw) / 2.0
    return Pose2D((left.x + right.x) / 2.0, (left.y + right.y) / 2.0, yaw)


def beside(middle: Pose2D, side: int) -> Pose2D:
    """Return a pose half a stance width beside another: of a foot from the middle, or the other way round."""
    return move_pose(middle, 0.0, WIDTH / 2.0 if side == LEFT else -WIDTH / 2.0)


def next_place(stance: Pose2D, side: int, wish: Wish, seconds: float) -> Pose2D:
    """Return where the foot of `side` comes down beside the standing foot, after a step of `seconds`.

    In steps sideways and in turns, the outer foot moves away first; the inner foot follows in the next step.
    """
    middle = beside(stance, side)
    ahead, left, turn = _stride(middle, wish, seconds)
    left = 2.0 * left if side == (LEFT if left > 0.0 else RIGHT) else 0.0
    turn = 2.0 * turn if side == (LEFT if turn > 0.0 else RIGHT) else 0.0
    way = in_frame(np.array((ahead, left)), -turn / 2.0)
    return within_reach(beside(move_pose(middle, float(way[0]), float(way[1]), turn), side), stance, side)


def _stride(middle: Pose2D, wish: Wish, seconds: float) -> tuple[float, float, float]:
    """Return the average displacement of a step (m, m, rad), in the frame between the feet."""
    if wish.place is not None:
        left = seen_from(middle, wish.place)
        if math.hypot(left.x, left.y) < NEAR:
            parts = zip((left.x, left.y, left.yaw), LITTLE, strict=True)
            x, y, turn = (min(max(part, -most), most) for part, most in parts)
            return x, y / 2.0, turn / 2.0
    speed = wish.velocity
    return speed.x * seconds, speed.y * seconds, speed.yaw * seconds


def within_reach(foot: Pose2D, stance: Pose2D, side: int) -> Pose2D:
    """Return the pose nearest to `foot` that the leg can reach while the other foot stands at `stance`."""
    seen = seen_from(stance, foot)
    outwards = seen.y if side == LEFT else -seen.y
    outwards = min(max(outwards, NARROWEST), WIDEST)
    ahead = min(max(seen.x, -FARTHEST), FARTHEST)
    turn = min(max(seen.yaw, -MOST_TURN), MOST_TURN)
    return move_pose(stance, ahead, outwards if side == LEFT else -outwards, turn)
