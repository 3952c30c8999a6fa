"""Cancel requests: the goals that they ask for, and the server's answers (action_msgs/srv/CancelGoal).

| goal id | stamp | asks for                                  |
|---------|-------|-------------------------------------------|
| zero    | zero  | every goal that can still be cancelled    |
| zero    | set   | all goals accepted at or before the stamp |
| set     | zero  | the goal with this id                     |
| set     | set   | the goal with this id, and all goals accepted at or before the stamp |

Only a request with an id and without a stamp can be refused. The answer is UNKNOWN_GOAL_ID if there is no
such goal, and GOAL_TERMINATED if the goal has ended or is being cancelled already. REJECTED is never sent: if
the user's callback refuses, this server answers NONE with an empty list, like rclpy.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from goalwire.rules.goals.ids import NO_ID
from goalwire.rules.time import S_TO_NS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.states import GoalStatus

RequestT = TypeVar('RequestT')


class CancelCode(IntEnum):
    """The return_code of action_msgs/srv/CancelGoal."""

    NONE = 0
    REJECTED = 1
    UNKNOWN_GOAL_ID = 2
    GOAL_TERMINATED = 3


class Candidate(Protocol):
    """The attributes of a goal that `choose` reads."""

    @property
    def stamp_ns(self) -> int:
        """The time at which the goal was accepted (ROS time)."""

    @property
    def status(self) -> GoalStatus:
        """The goal's status."""


class Cancellation(Generic[RequestT]):
    """One cancel request, while the user decides about its goals."""

    __slots__ = ('came_too_late', 'canceling', 'goals', 'is_for_one', 'request', 'undecided')

    def __init__(self, request: RequestT, goals: tuple[GoalId, ...], *, is_for_one: bool) -> None:
        self.request = request
        self.goals = goals
        self.is_for_one = is_for_one
        """True if a single goal was asked for, only by its id."""
        self.undecided = set(goals)
        self.canceling: dict[GoalId, int] = {}
        """The goals that went to CANCELING, with the stamps of their acceptance."""
        self.came_too_late = False
        """True once the user has decided about a goal that could no longer be cancelled."""

    @property
    def code(self) -> CancelCode:
        """The code of the answer; valid once the user has decided about all goals."""
        return CancelCode.GOAL_TERMINATED if self.is_for_one and self.came_too_late else CancelCode.NONE

    @property
    def granted(self) -> tuple[tuple[GoalId, int], ...]:
        """The goals that are being cancelled, with their acceptance stamps, in the order of `goals`."""
        return tuple((id_, self.canceling[id_]) for id_ in self.goals if id_ in self.canceling)


class Cancellations(Generic[RequestT]):
    """The cancel requests of one action server about which the user has still to decide."""

    def __init__(self) -> None:
        self.open: dict[int, Cancellation[RequestT]] = {}
        """The open requests, by their numbers."""
        self._next = 0

    def add(self, cancellation: Cancellation[RequestT]) -> int:
        """Add a cancel request, and return its number."""
        number = self._next
        self._next += 1
        self.open[number] = cancellation
        return number

    def take_decision(self, number: int, goal_id: GoalId) -> Cancellation[RequestT] | None:
        """Note that the user has decided about a goal, and return the cancel request.

        Returns None if the request does not await a decision about that goal.
        """
        cancellation = self.open.get(number)
        if cancellation is None or goal_id not in cancellation.undecided:
            return None
        cancellation.undecided.remove(goal_id)
        return cancellation


def read_stamp(stamp: object) -> int:
    """Return the time of a cancel request in ns.

    Raises TypeError for anything but a Time or a builtin_interfaces/msg/Time, ValueError for a time that is
    not above 0: such a request would cancel all goals.
    """
    nanoseconds: object = getattr(stamp, 'nanoseconds', None)
    if nanoseconds is None and hasattr(stamp, 'nanosec'):
        nanoseconds = stamp.sec * S_TO_NS + stamp.nanosec  # type: ignore[attr-defined]
    if not isinstance(nanoseconds, int):
        raise TypeError(f'a Time or a builtin_interfaces/msg/Time is needed, not {stamp!r}')
    if nanoseconds <= 0:
        raise ValueError(f'a time above 0 is needed, not {stamp}; cancel_all_goals cancels all')
    return nanoseconds


def choose(
    goals: Mapping[GoalId, Candidate], goal_id: GoalId, stamp_ns: int
) -> tuple[CancelCode, tuple[GoalId, ...]]:
    """Return NONE with the goals to ask the user about, in the order of `goals`; or the code of a refusal."""
    if goal_id != NO_ID and stamp_ns == 0:
        goal = goals.get(goal_id)
        if goal is None:
            return CancelCode.UNKNOWN_GOAL_ID, ()
        if not goal.status.is_cancelable:
            return CancelCode.GOAL_TERMINATED, ()
        return CancelCode.NONE, (goal_id,)
    everything = goal_id == NO_ID and stamp_ns == 0
    return CancelCode.NONE, tuple(
        id_
        for id_, goal in goals.items()
        if goal.status.is_cancelable and (everything or id_ == goal_id or goal.stamp_ns <= stamp_ns)
    )
