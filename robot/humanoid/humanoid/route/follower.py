"""Follows a path and avoids obstacles: chooses the best of many short arcs that keep clear of obstacles.

This is the dynamic window approach (Fox, Burgard and Thrun, 1997), towards a point ahead on the path.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from humanoid.maps import Array
from humanoid.model import BASE
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.route.costmap import KEEPS, Costmap

FASTEST = min(0.6, BASE.max_speed)  # m/s: top speed indoors, with people around
SPEEDS = (0.1, 0.2, 0.35, 0.5, FASTEST)
TURNS = np.linspace(-1.2, 1.2, 25)  # rad/s
LOOKS = np.array([0.15, 0.3, 0.5, 0.75, 1.0, 1.2])  # s ahead at which an arc's clearance is checked
AHEAD = 0.7  # m from the robot to the point of the path that it heads for
TURN_FIRST = 0.9  # rad: if the point is farther off the heading, the robot first turns on the spot
AIMED = 0.1  # rad: if every arc is blocked, it turns on the spot unless the point is so near its heading
NEAR = 0.35  # m: within this distance the robot moves straight to the goal, also sideways
CAREFUL = 0.2  # m/s: top speed of a robot that is too near to an obstacle
TOO_NEAR = KEEPS - 0.05  # m: with less clearance it first steps away
STEP, BEARINGS = 0.1, np.linspace(0.0, math.tau, 16, endpoint=False)  # m and rad: the steps that it considers
SLOW = 0.2  # m/s within NEAR of the goal
WITHIN, TURNED_WITHIN = 0.04, 0.05  # m and rad: within these the robot has arrived
ROOMY = 0.6  # m: more clearance does not make an arc better


class Blocked(Exception):
    """Every possible motion comes too near to an obstacle."""


def has_arrived(pose: Pose2D, goal: Pose2D) -> bool:
    """Return True if the robot stands at the goal with the right heading."""
    away = math.hypot(goal.x - pose.x, goal.y - pose.y)
    return away <= WITHIN and abs(turn_between(pose.yaw, goal.yaw)) <= TURNED_WITHIN


def velocity(costmap: Costmap, path: Array, pose: Pose2D, goal: Pose2D, *, stops: bool = True) -> Velocity2D:
    """Return the base's velocity now. `stops`: the path ends at `goal`, with its heading. Raises Blocked."""
    if (step := _step_away(costmap, pose)) is not None:
        return step
    away = math.hypot(goal.x - pose.x, goal.y - pose.y)
    if stops and away <= NEAR:
        return _last_piece(costmap, pose, goal, away)
    x, y = _carrot(path, pose)
    bearing = turn_between(pose.yaw, math.atan2(y - pose.y, x - pose.x))
    turning = Velocity2D(yaw=math.copysign(min(1.0, 1.5 * abs(bearing)), bearing))
    if abs(bearing) > TURN_FIRST:
        return turning
    try:
        return _best_arc(costmap, pose, x, y)
    except Blocked:
        if abs(bearing) > AIMED:
            return turning
        raise


def measure_rest(path: Array, pose: Pose2D) -> float:
    """Return the length of the rest of the path, from the robot to its end, in m."""
    nearest = _nearest(path, pose)
    rest = np.concatenate([[[pose.x, pose.y]], path[min(nearest + 1, len(path) - 1) :]])
    return float(np.hypot(*np.diff(rest, axis=0).T).sum())


def _nearest(path: Array, pose: Pose2D) -> int:
    return int(np.hypot(path[:, 0] - pose.x, path[:, 1] - pose.y).argmin())


def _carrot(path: Array, pose: Pose2D) -> tuple[float, float]:
    """Return the path's first point that is AHEAD m or more from the robot, after its nearest point."""
    ahead = path[_nearest(path, pose) :]
    far = np.hypot(ahead[:, 0] - pose.x, ahead[:, 1] - pose.y) >= AHEAD
    x, y = ahead[int(far.argmax())] if far.any() else ahead[-1]
    return float(x), float(y)


def _last_piece(costmap: Costmap, pose: Pose2D, goal: Pose2D, away: float) -> Velocity2D:
    """Return a velocity straight to the goal, sideways too, while the base turns to the goal's heading."""
    turn = turn_between(pose.yaw, goal.yaw)
    turning = math.copysign(min(1.0, 1.5 * abs(turn) + 0.1), turn)
    if abs(turn) <= TURNED_WITHIN / 2.0:
        turning = 0.0
    if away <= WITHIN / 2.0:
        return Velocity2D(yaw=turning)
    speed = min(SLOW, 1.2 * away + 0.02)
    x, y = (goal.x - pose.x) / away * speed, (goal.y - pose.y) / away * speed
    ahead = np.array([[pose.x + x * after, pose.y + y * after] for after in (0.3, 0.6)])
    if not _keeps_away(costmap, pose, costmap.clearance_at(ahead)[None, :])[0]:
        raise Blocked
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Velocity2D(cos * x + sin * y, cos * y - sin * x, turning)


def _best_arc(costmap: Costmap, pose: Pose2D, x: float, y: float) -> Velocity2D:
    speeds, turns = (each.reshape(-1) for each in np.meshgrid(SPEEDS, TURNS))
    yaws = pose.yaw + turns[:, None] * LOOKS[None, :]
    chord = pose.yaw + turns[:, None] * LOOKS[None, :] / 2.0
    ways = speeds[:, None] * LOOKS[None, :] * np.sinc(turns[:, None] * LOOKS[None, :] / (2.0 * math.pi))
    places = np.stack([pose.x + ways * np.cos(chord), pose.y + ways * np.sin(chord)], axis=-1)
    clearance = costmap.clearance_at(places.reshape(-1, 2)).reshape(ways.shape)
    good = _keeps_away(costmap, pose, clearance)
    if _clearance_here(costmap, pose) < KEEPS:
        good &= speeds <= CAREFUL
    if not good.any():
        raise Blocked
    apart = np.hypot(places[..., 0] - x, places[..., 1] - y).min(axis=1)
    end_x, end_y = places[:, 2, 0], places[:, 2, 1]
    off = np.abs((np.arctan2(y - end_y, x - end_x) - yaws[:, 2] + math.pi) % math.tau - math.pi)
    tight = np.maximum(ROOMY - clearance.min(axis=1), 0.0)
    score = -apart - 0.25 * off - 4.0 * tight + 0.15 * speeds
    best = int(np.where(good, score, -np.inf).argmax())
    return Velocity2D(float(speeds[best]), 0.0, float(turns[best]))


def _keeps_away(costmap: Costmap, pose: Pose2D, clearance: Array) -> NDArray[np.bool_]:
    """Return which paths (a row of clearances each) keep clear of obstacles, or lead away from a near one."""
    now = _clearance_here(costmap, pose)
    least = clearance.min(axis=1)
    leads_away = (now < KEEPS) & (least >= now - 0.01) & (clearance[:, -1] > now)
    good: NDArray[np.bool_] = (least >= KEEPS) | leads_away
    return good


def _clearance_here(costmap: Costmap, pose: Pose2D) -> float:
    return float(costmap.clearance_at(np.array([[pose.x, pose.y]]))[0])


def _step_away(costmap: Costmap, pose: Pose2D) -> Velocity2D | None:
    """Return a velocity away from an obstacle that is much too near, also sideways; None if there is none."""
    now = _clearance_here(costmap, pose)
    if now >= TOO_NEAR:
        return None
    ways = np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    places = np.array([pose.x, pose.y]) + STEP * ways
    clearance = costmap.clearance_at(places)
    best = int(clearance.argmax())
    if clearance[best] <= now:
        return None
    x, y = ways[best] * CAREFUL
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return Velocity2D(float(cos * x + sin * y), float(cos * y - sin * x))


def backwards(costmap: Costmap, pose: Pose2D, speed: float) -> Velocity2D:
    """Return a slow backward velocity, or STANDING if an obstacle is behind."""
    back = np.array([-math.cos(pose.yaw), -math.sin(pose.yaw)])
    behind = np.array([pose.x, pose.y]) + np.array([[0.1], [0.2]]) * back
    clear = _keeps_away(costmap, pose, costmap.clearance_at(behind)[None, :])[0]
    return Velocity2D(-speed) if clear else STANDING
