"""The task of the navigator for one goal: the common part of all its tasks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import Enum

from humanoid.goal_endings import End, Ending
from humanoid.maps import Array
from humanoid.navigation.base import STANDING, Pose2D, Velocity2D
from humanoid.route.costmap import Costmap

LOST_AFTER = 10.0  # s without a pose, after which the task fails; until then the robot stands


class Failure(Enum):
    """Why a task failed, for clients that read error codes."""

    NONE = 'none'
    NO_WAY = 'no way'
    STUCK = 'stuck'
    BLOCKED = 'blocked'
    LOST = 'lost'
    LATE = 'late'


class Task(ABC):
    """Moves the robot for one goal, tick by tick, until `ending` is set.

    Poses are in the map's frame, distances in m, and all times in s of the same clock.
    """

    def __init__(self, now: float) -> None:
        self.began = now
        self.path: Array | None = None
        """The path that the robot follows now: points (n, 2)."""
        self.left = 0.0
        """The way left to the end of the goal."""
        self.recoveries = 0
        self.failure = Failure.NONE
        self.ending: Ending | None = None
        self._seen_at = now  # when the pose was last known

    @property
    @abstractmethod
    def aim(self) -> str:
        """Return the aim of the goal as text for the log."""

    @property
    def doing(self) -> str:
        """The robot's present activity, as text for the diagnostics."""
        return 'on the way'

    @property
    def is_measured(self) -> bool:
        """True once the progress is known, so that feedback can be given."""
        return self.path is not None

    @property
    def time_left(self) -> float:
        return 0.0

    @property
    def poses_left(self) -> int:
        """The number of the goal's poses that the robot has not passed yet."""
        return 0

    @property
    def path_end(self) -> Pose2D:
        """The pose at the end of `path`."""
        return Pose2D()

    def tick(self, costmap: Costmap, pose: Pose2D | None, now: float) -> Velocity2D:
        """Return the base's velocity until the next tick. `pose` is None while it is unknown."""
        if pose is None:
            if now - self._seen_at > LOST_AFTER:
                self._give_up(Failure.LOST, 'The robot does not know where it is: no transform from the map')
            return STANDING
        self._seen_at = now
        return self._advance(costmap, pose, now)

    @abstractmethod
    def _advance(self, costmap: Costmap, pose: Pose2D, now: float) -> Velocity2D:
        """Return the base's velocity until the next tick, now that the robot's pose is known."""

    def _succeed(self, message: str) -> None:
        self.ending = Ending(End.SUCCEEDED, message)

    def _give_up(self, failure: Failure, reason: str) -> None:
        self.failure, self.ending = failure, Ending(End.ABORTED, reason)
