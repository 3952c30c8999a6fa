"""One drive along a given path: it plans nothing, and waits for a while if something stands on the path."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from humanoid.maps import Array
from humanoid.model import BASE
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.route import follower
from humanoid.route.costmap import Costmap
from humanoid.route.planner import SPACING, points_of, space
from humanoid.route.task import Failure, Task

BEGINS_WITHIN, GOES_ON_WITHIN = 0.1, 0.02  # m: of points that are as near, up to this, the first one counts
SEARCHED = 0.6  # m of the path, from the point that the robot has come to, in which it looks for itself
IN_SIGHT = 0.9  # m of the path, from that point, that the robot heads for and checks for obstacles
PASSED_WITHIN = 0.15  # m: within this distance of a turn back, the robot goes on behind it
UNDER_IT = 0.2  # m around the robot that are not checked: it stands there already
LAST_PIECE = 0.6  # m of the path left, from which the robot may arrive
BLOCKED_FOR = 6.0  # s for which something stands on the path, after which the drive fails
STUCK_AFTER, STUCK_WAY = 10.0, 0.1  # s, m: the drive fails if the way left became no shorter in this time


class PathErrand(Task):
    """One drive along the line through `poses`, in the map's frame; it ends with the last one's heading.

    The robot remembers how far along the path it has come, so a path may cross itself or end where it begins.
    """

    def __init__(self, poses: Sequence[Pose2D], now: float) -> None:
        super().__init__(now)
        self._end = poses[-1]
        self._line = self.path = space(points_of(poses))
        self._rest = _measure_rests(self._line)
        self._come_to: int | None = None  # the index of the point that the robot has come to
        self._free_at = now  # when nothing stood on the path last
        self._progress = math.inf, now  # the shortest way left so far, and when it was that short

    @property
    def aim(self) -> str:
        return f'along {self._rest[0]:.2f} m of path to ({self._end.x:.2f}, {self._end.y:.2f}) m on the map'

    @property
    def doing(self) -> str:
        return 'on the way along a given path'

    @property
    def is_measured(self) -> bool:
        return self._come_to is not None

    @property
    def path_end(self) -> Pose2D:
        return self._end

    def _advance(self, costmap: Costmap, pose: Pose2D, now: float) -> Velocity2D:
        at = self._come_to = self._locate(pose)
        x, y = self._line[at]
        self.left = math.hypot(x - pose.x, y - pose.y) + float(self._rest[at])
        may_arrive = float(self._rest[at]) <= LAST_PIECE
        if may_arrive and follower.has_arrived(pose, self._end):
            self.left = 0.0
            self._succeed('The robot has followed the path to its end')
            return STANDING
        part = self._line[at : at + _count(IN_SIGHT)]
        if self._is_blocked(costmap, part, pose, now):
            return STANDING
        near = _leave(part, pose)
        if len(near) < len(part) and math.hypot(*(near[-1] - [pose.x, pose.y])) <= PASSED_WITHIN:
            self._come_to = at + len(near) - 1
        try:
            wish = follower.velocity(costmap, near, pose, self._end, stops=may_arrive)
        except follower.Blocked:
            wish = STANDING
        self._watch_progress(pose, now)
        return STANDING if self.ending else wish

    def _locate(self, pose: Pose2D) -> int:
        """Return the index of the path's point where the robot is now; it never goes back."""
        apart = np.hypot(self._line[:, 0] - pose.x, self._line[:, 1] - pose.y)
        if self._come_to is None:
            return int((apart <= apart.min() + BEGINS_WITHIN).argmax())
        apart = apart[self._come_to : self._come_to + _count(SEARCHED)]
        return self._come_to + int((apart <= apart.min() + GOES_ON_WITHIN).argmax())

    def _is_blocked(self, costmap: Costmap, part: Array, pose: Pose2D, now: float) -> bool:
        """Return True while the robot would touch something on this part of the path; give up in the end."""
        ahead = part[np.hypot(part[:, 0] - pose.x, part[:, 1] - pose.y) > UNDER_IT]
        bars = ahead[costmap.clearance_at(ahead) < BASE.radius]
        if not len(bars):
            self._free_at = now
            return False
        self._progress = math.inf, now  # the wait is not the robot's fault
        if now - self._free_at > BLOCKED_FOR:
            x, y = bars[0]
            self._give_up(Failure.BLOCKED, f'Blocked: something stands on the path near ({x:.1f}, {y:.1f}) m')
        return True

    def _watch_progress(self, pose: Pose2D, now: float) -> None:
        """Give up if the robot has come no nearer to the path's end for a while."""
        turn = abs(turn_between(pose.yaw, self._end.yaw)) if self.left < follower.NEAR else 0.0
        measure, (shortest, since) = self.left + 0.2 * turn, self._progress
        if measure < shortest - STUCK_WAY:
            self._progress = measure, now
        elif now - since > STUCK_AFTER:
            where = f'({pose.x:.2f}, {pose.y:.2f}) m'
            self._give_up(Failure.STUCK, f'Stuck at {where}, {self.left:.2f} m before the end of the path')


def _measure_rests(line: Array) -> Array:
    """Return for each point the length of the line from there to its end, in m."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    rests: Array = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    return rests


def _leave(part: Array, pose: Pose2D) -> Array:
    """Return the beginning of this part of the path: up to where the path turns back towards the robot.

    A robot that headed for a point behind such a turn would cut the turn off.
    """
    steps = np.diff(np.hypot(part[:, 0] - pose.x, part[:, 1] - pose.y))
    rises = np.flatnonzero(steps > 0.0)
    if not len(rises):
        return part
    returns = np.flatnonzero(steps[rises[0] :] < 0.0)
    return part[: rises[0] + returns[0] + 1] if len(returns) else part


def _count(reach: float) -> int:
    """Return how many points of a line that `space` has made cover `reach` m, with both ends."""
    return math.ceil(reach / SPACING) + 1
