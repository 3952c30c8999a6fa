"""One drive to a goal or through several: plans a path, follows it, recovers, and decides how it ends."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from humanoid.maps import Array
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D, turn_between
from humanoid.route import follower
from humanoid.route.costmap import KEEPS, Costmap
from humanoid.route.planner import NoWay, length, plan
from humanoid.route.task import Failure, Task

REPLAN_EVERY = 2.0  # s between two plans; if an obstacle stands on the path, RETRY_EVERY counts
RETRY_EVERY = 1.0  # s between two attempts to find a path
LETS_PASS, DETOUR = 4.0, 2.0  # s and m: how long it waits for what bars its path, before a longer detour
LOOK_AGAIN_AFTER = 3.0  # s without a path, after which scanned obstacles are forgotten once
NO_WAY_FOR = 10.0  # s without a path, after which the drive fails: people walk on or turn back before
STUCK_AFTER = 4.0  # s: the robot is stuck if it came less than STUCK_WAY nearer in this time
STUCK_WAY = 0.1  # m
WAITS = 2.0  # s: the first recovery is to wait
BACKS_UP, BACKS_UP_AT = 1.5, 0.15  # s and m/s: the second recovery is to back up
MOST_RECOVERIES = 10  # after more recoveries the drive fails
PASSED_WITHIN = 0.3  # m: within this distance an intermediate pose counts as passed
CRUISES_AT = 0.45  # m/s: the speed by which the time left is estimated


class Errand(Task):
    """One drive through `targets`, given in the map's frame. All times are in s of the same clock.

    If it `stops_at_each`, it arrives at each target as at the last one; otherwise it passes the others by.
    """

    def __init__(self, targets: Sequence[Pose2D], now: float, *, stops_at_each: bool = False) -> None:
        super().__init__(now)
        self.targets = list(targets)
        self.stops_at_each = stops_at_each
        self._planned_at = -math.inf
        self._way_at = now  # when planning last found a path
        self._progress = math.inf, now  # the shortest way left so far, and when it was that short
        self._recovers_until, self._backs_up = -math.inf, False
        self._looked_again = False
        self._barred_at: float | None = None  # when something came into the path's way, if it is still there

    @property
    def aim(self) -> str:
        return f'({self.targets[-1].x:.2f}, {self.targets[-1].y:.2f}) m on the map'

    @property
    def time_left(self) -> float:
        """The estimated time left, in s."""
        return self.left / CRUISES_AT

    @property
    def poses_left(self) -> int:
        return len(self.targets)

    @property
    def path_end(self) -> Pose2D:
        return self.targets[0]

    def _advance(self, costmap: Costmap, pose: Pose2D, now: float) -> Velocity2D:
        while len(self.targets) > 1 and self._is_done_with(self.targets[0], pose):
            del self.targets[0]
            self.path, self._planned_at = None, -math.inf  # it led to the target before
        if len(self.targets) == 1 and follower.has_arrived(pose, self.targets[0]):
            self.left = 0.0
            self._succeed('Navigation completed successfully')
            return STANDING
        if not self._has_way(costmap, pose, now) or self.path is None:
            return STANDING
        self.left = follower.measure_rest(self.path, pose) + _further(self.targets)
        if now < self._recovers_until:
            return follower.backwards(costmap, pose, BACKS_UP_AT) if self._backs_up else STANDING
        try:
            stops = self.stops_at_each or len(self.targets) == 1
            wish = follower.velocity(costmap, self.path, pose, self.targets[0], stops=stops)
        except follower.Blocked:
            wish = STANDING
        self._watch_progress(pose, now)
        return STANDING if self.ending else wish

    def _is_done_with(self, target: Pose2D, pose: Pose2D) -> bool:
        """Return True if the next target is the one after `target`."""
        if self.stops_at_each:
            return follower.has_arrived(pose, target)
        return _apart(pose, target) <= PASSED_WITHIN

    def _has_way(self, costmap: Costmap, pose: Pose2D, now: float) -> bool:
        """Plan a path if one is due; return False while there is no path."""
        is_barred = self._is_barred(costmap, pose)
        if not is_barred:
            self._barred_at = None
        elif self._barred_at is None:
            self._barred_at = now
        pause = RETRY_EVERY if self.path is None or is_barred else REPLAN_EVERY
        if now - self._planned_at < pause:
            return self.path is not None
        self._planned_at = now
        try:
            path = _plan(costmap, pose, self.targets[0])
        except NoWay as problem:
            self.path = None
            if now - self._way_at >= LOOK_AGAIN_AFTER and not self._looked_again:
                self._looked_again = True
                costmap.forget()
            elif now - self._way_at >= NO_WAY_FOR:
                self._give_up(Failure.NO_WAY, f'No way: {explain(costmap, pose, self.targets[0], problem)}')
            return False
        self._way_at = now
        if not self._lets_pass(path, pose, now):
            self.path = path
        return True

    def _lets_pass(self, path: Array, pose: Pose2D, now: float) -> bool:
        """Return True if the robot had better wait than take `path`: people walk on or turn back."""
        if self.path is None or self._barred_at is None or now - self._barred_at >= LETS_PASS:
            return False
        return length(path) > follower.measure_rest(self.path, pose) + DETOUR

    def _is_barred(self, costmap: Costmap, pose: Pose2D) -> bool:
        """Return True if an obstacle stands on the path ahead."""
        if self.path is None:
            return False
        apart = np.hypot(self.path[:, 0] - pose.x, self.path[:, 1] - pose.y)
        ahead = self.path[int(apart.argmin()) :]
        ahead = ahead[np.hypot(ahead[:, 0] - pose.x, ahead[:, 1] - pose.y) > 0.2]
        return bool(len(ahead)) and bool((costmap.clearance_at(ahead) < KEEPS - 0.02).any())

    def _watch_progress(self, pose: Pose2D, now: float) -> None:
        """If the robot is stuck, begin a recovery (waiting or backing up, in turn); give up after many."""
        goal = self.targets[0]
        turn = abs(turn_between(pose.yaw, goal.yaw)) if _apart(pose, goal) < follower.NEAR else 0.0
        measure = self.left + 0.2 * turn
        shortest, since = self._progress
        if (
            measure < shortest - STUCK_WAY or measure > shortest + 1.0
        ):  # nearer to the goal, or on a new, longer path
            self._progress = measure, now
            return
        if now - since <= STUCK_AFTER:
            return
        self.recoveries += 1
        if self.recoveries > MOST_RECOVERIES:
            where = f'({pose.x:.2f}, {pose.y:.2f}) m'
            self._give_up(Failure.STUCK, f'Stuck at {where} after {MOST_RECOVERIES} recoveries')
            return
        self._backs_up = self.recoveries % 2 == 0
        self._recovers_until = now + (BACKS_UP if self._backs_up else WAITS)
        self._progress = math.inf, self._recovers_until
        self._planned_at = -math.inf


def _plan(costmap: Costmap, pose: Pose2D, goal: Pose2D) -> Array:
    """Plan a path; if all are barred, one through obstacles that may have gone by then. Raises NoWay."""
    try:
        return plan(costmap.geometry, costmap.clearance, pose, goal)
    except NoWay as problem:
        try:
            return plan(costmap.geometry, costmap.forecast(), pose, goal)
        except NoWay:
            raise problem from None


def explain(costmap: Costmap, pose: Pose2D, goal: Pose2D, problem: NoWay) -> str:
    """Return why there is no path; if the map alone shows a path, name the scanned obstacle on that path."""
    try:
        mapped = plan(costmap.geometry, costmap.mapped, pose, goal)
    except NoWay:
        return str(problem)
    barred = mapped[costmap.clearance_at(mapped) < KEEPS]
    if not len(barred):
        return str(problem)
    x, y = barred[0]
    return f'the map shows one, and something stands on it near ({x:.1f}, {y:.1f}) m'


def _apart(pose: Pose2D, other: Pose2D) -> float:
    return math.hypot(other.x - pose.x, other.y - pose.y)


def _further(targets: Sequence[Pose2D]) -> float:
    """Return the length, in m, of straight lines from the next target through all later targets."""
    if len(targets) < 2:
        return 0.0
    return length(np.array([[target.x, target.y] for target in targets]))
