"""One drive by hand: somebody sends velocities, and the robot stops before what is in the way."""

from __future__ import annotations

import math

from humanoid.navigation.base import STANDING, VELOCITY_LASTS, Pose2D, Velocity2D
from humanoid.navigation.guard import slow_down
from humanoid.route.costmap import KEEPS, Costmap
from humanoid.route.task import Failure, Task


class TeleopErrand(Task):
    """Moves the robot by the velocities that `hear` is given, for `allowed` s, or until `finish`.

    With `allowed` of 0 or less there is no limit of time.
    """

    def __init__(self, allowed: float, now: float) -> None:
        super().__init__(now)
        self._allowed = allowed
        self._wish, self._heard_at = STANDING, -math.inf

    @property
    def aim(self) -> str:
        return f'cmd_vel_teleop drives {"without limit of time" if self._allowed <= 0.0 else self._limit}'

    @property
    def doing(self) -> str:
        return 'driven by cmd_vel_teleop'

    @property
    def is_measured(self) -> bool:
        return True

    @property
    def _limit(self) -> str:
        return f'for {self._allowed:g} s'

    def hear(self, wish: Velocity2D, now: float) -> None:
        """Take a velocity from somebody. One that is not finite counts as standing."""
        is_finite = all(map(math.isfinite, (wish.x, wish.y, wish.yaw)))
        self._wish, self._heard_at = (wish if is_finite else STANDING), now

    def finish(self) -> None:
        """End the drive: whoever drives says that the robot is where it should be."""
        if self.ending is None:
            self._succeed('Assisted teleop was ended by preempt_teleop')

    def tick(self, costmap: Costmap, pose: Pose2D | None, now: float) -> Velocity2D:
        if self.ending is None and now - self.began > self._allowed > 0.0:
            self._give_up(Failure.LATE, f'Assisted teleop is over: it was allowed {self._limit}')
        return STANDING if self.ending else super().tick(costmap, pose, now)

    def _advance(self, costmap: Costmap, pose: Pose2D, now: float) -> Velocity2D:
        if not 0.0 <= now - self._heard_at <= VELOCITY_LASTS:
            return STANDING
        return slow_down(self._wish, pose, KEEPS, costmap.clearance_at)
