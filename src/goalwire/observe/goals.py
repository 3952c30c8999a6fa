"""The goals of every client, as the status and feedback topics of the action servers report them."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from goalwire.observe.progress import Progress, ProgressError, likely_field
from goalwire.rules.goals.states import GoalStatus

SENT = 'SENT'
"""The status of a goal whose server has not answered yet."""
ACTIVE = frozenset({SENT, *(status.name for status in GoalStatus if status.is_active)})
KEPT = 300
"""The number of goals that are kept. If there are more, the oldest ended goals are dropped."""
_TICKS = 400


def status_name(number: int) -> str:
    """Return the name of a status of action_msgs/msg/GoalStatus; UNKNOWN for any other number."""
    return GoalStatus(number).name if 0 <= number < len(GoalStatus) else GoalStatus.UNKNOWN.name


class ReportedGoal(NamedTuple):
    """A goal as its server reports it."""

    goal_id: str
    status: str
    accepted: float
    """The time of acceptance, in s since 1970 by the server's clock."""

    @property
    def is_active(self) -> bool:
        """True until the goal ends."""
        return self.status in ACTIVE


def read_reported_goals(array: Any) -> list[ReportedGoal]:
    """Return the goals of an action_msgs/msg/GoalStatusArray, in the order of their acceptance."""
    return [
        ReportedGoal(
            bytes(entry.goal_info.goal_id.uuid).hex(),
            status_name(entry.status),
            entry.goal_info.stamp.sec + entry.goal_info.stamp.nanosec / 1e9,
        )
        for entry in array.status_list
    ]


class Goal:
    """One goal, as far as this process has observed it. Times are readings of the monotonic clock, in s."""

    def __init__(self, action: str, goal_id: str, now: float) -> None:
        self.action = action
        self.goal_id = goal_id
        self.status = SENT
        self.began = now
        self.ended: float | None = None
        self.accepted: float | None = None
        """The time of acceptance, in s since 1970 by the server's clock."""
        self.marks: list[tuple[float, str]] = []
        """The statuses of the goal, each with the time at which it was noticed."""
        self.ticks: deque[float] = deque(maxlen=_TICKS)
        """The times at which feedback came."""
        self.feedback: Any = None
        """The latest feedback message."""
        self.progress: float | None = None
        """The goal's progress, 0 to 1; None if the feedback does not show it."""
        self.result: Mapping[str, Any] | None = None
        self.problem = ''
        self.request: Mapping[str, Any] | None = None
        """The goal message, if this process has sent the goal; else None."""
        self._saw_start = True
        self._readers: dict[str, Progress] = {}

    @property
    def is_mine(self) -> bool:
        """True if this process has sent the goal."""
        return self.request is not None

    @property
    def is_active(self) -> bool:
        """True until the goal ends."""
        return self.status in ACTIVE

    def move(self, status: str, now: float) -> bool:
        """Note a status. Return False if it changes nothing, such as a status after the goal's end.

        The answer to a goal's request may come after its status EXECUTING. So only a SENT goal becomes
        ACCEPTED.
        """
        if status == self.status or not self.is_active or (status == 'ACCEPTED' and self.status != SENT):
            return False
        self.status = status
        self.marks.append((now, status))
        if status not in ACTIVE:
            self.ended = now
            if status == 'SUCCEEDED' and self.progress is not None:
                self.progress = 1.0
        return True

    def miss_start(self) -> None:
        """Note that the goal ran before its feedback was subscribed to, so the first value of its progress is
        unknown.
        """
        self._saw_start = False
        self._readers.clear()
        self.progress = None

    def take_feedback(self, feedback: Any, now: float, field: str | None = None) -> None:
        """Note a feedback message. `field` names the field with the progress, in the form that `Progress`
        takes.

        If the message has no such field, the field whose name suggests progress is used.
        """
        self.ticks.append(now)
        self.feedback = feedback
        for spec in (field, likely_field(feedback)):
            if spec is None:
                continue
            if spec not in self._readers:
                self._readers[spec] = Progress(spec, saw_start=self._saw_start)
            with suppress(ProgressError):  # the feedback of this action has no such field
                done = self._readers[spec].read(feedback)
                self.progress = self.progress if done is None else done
                return


class GoalTable:
    """The goals of all actions, in the order in which they were noticed."""

    def __init__(self, field: str | None = None, kept: int = KEPT) -> None:
        """`field` names the feedback's field with the progress, in the form that `Progress` takes; `kept`
        goals are kept.
        """
        self._field = field
        self._kept = kept
        self._goals: OrderedDict[tuple[str, str], Goal] = OrderedDict()
        self._reported: dict[str, list[str]] = {}
        self._watched_since: dict[str, float] = {}
        self.version = 0
        """A number that rises with each change of the table."""

    def __iter__(self) -> Iterator[Goal]:
        return iter(self._goals.values())

    def __len__(self) -> int:
        return len(self._goals)

    def get(self, action: str, goal_id: str) -> Goal | None:
        """Return the goal with this id; None if it is unknown."""
        return self._goals.get((action, goal_id))

    def active(self, action: str | None = None) -> list[Goal]:
        """Return the goals, of one action or of all, that have not ended."""
        return [goal for goal in self if goal.is_active and action in {None, goal.action}]

    def list_reported(self, action: str, most_ended: int) -> list[Goal]:
        """Return the goals that the server last reported: the active ones, then the latest that ended."""
        goals = [self._goals[action, each] for each in self._reported.get(action, ())]
        ended = [goal for goal in goals if not goal.is_active]
        return [*(goal for goal in goals if goal.is_active), *ended[-most_ended:]]

    def watch(self, action: str, now: float) -> None:
        """Note that the observation of an action's goals begins now; earlier feedback was missed."""
        self._watched_since[action] = now

    def forget(self, action: str) -> None:
        """Remove the goals of an action from the table."""
        self._reported.pop(action, None)
        for key in [key for key in self._goals if key[0] == action]:
            del self._goals[key]
        self.version += 1

    def note_sent(self, action: str, goal_id: str, request: Mapping[str, Any], now: float) -> Goal:
        """Note a goal that this process sends."""
        goal = self._goal(action, goal_id, now)
        goal.request = request
        return goal

    def take_statuses(
        self, action: str, goals: Iterable[ReportedGoal], now: float, wall_offset: float = 0.0
    ) -> list[Goal]:
        """Note the statuses that a server reports, and return the goals that have changed.

        `now` plus `wall_offset` is the time in s since 1970, as times of acceptance are. For a goal that had
        already ended when it was first reported, the end is set to its begin, since the end is unknown.
        """
        news, ids = [], list[str]()
        since = self._watched_since.pop(action, None)
        for goal_id, status, accepted in goals:
            known = self._goals.get((action, goal_id))
            is_old = known is None and status not in ACTIVE  # the time of the goal's end is unknown
            if known is None:
                began = min(now, accepted - wall_offset) if accepted > 0 else now
                known = self._goal(action, goal_id, began)
            # If the server uses another clock, as in a simulation, a goal may seem older than it is, and lose
            # its progress.
            if since is not None and accepted - wall_offset < since and not known.is_mine:
                known.miss_start()
            known.accepted = accepted
            ids.append(goal_id)
            if known.move(status, known.began if is_old else now):
                news.append(known)
        self._reported[action] = [each for each in ids if (action, each) in self._goals]
        return news

    def take_feedback(self, action: str, goal_id: str, feedback: Any, now: float) -> Goal:
        """Note a feedback message, also of a goal that no status message has reported yet."""
        goal = self._goal(action, goal_id, now)
        goal.take_feedback(feedback, now, self._field)
        self.version += 1
        return goal

    def end(self, goal: Goal, status: str, problem: str, now: float) -> None:
        """Note the end of a goal that its server did not report: the goal was refused, or the server has
        gone.
        """
        goal.problem = problem
        goal.move(status, now)
        self.version += 1

    def note_change(self) -> None:
        """Note that another part of the program has changed a goal."""
        self.version += 1

    def _goal(self, action: str, goal_id: str, now: float) -> Goal:
        key = (action, goal_id)
        goal = self._goals.get(key)
        if goal is None:
            goal = self._goals[key] = Goal(action, goal_id, now)
            self._drop_old()
        self.version += 1
        return goal

    def _drop_old(self) -> None:
        while len(self._goals) > self._kept:
            ended = next((key for key, goal in self._goals.items() if not goal.is_active), None)
            self._goals.pop(ended) if ended is not None else self._goals.popitem(last=False)


def lanes(goals: Iterable[Goal], now: float, margin: float = 0.0) -> list[tuple[Goal, int]]:
    """Place goals in rows of their action: each in the first row whose last goal ended `margin` s before it
    began.
    """
    placed: list[tuple[Goal, int]] = []
    ends: dict[str, list[float]] = {}
    for goal in sorted(goals, key=lambda each: each.began):
        rows = ends.setdefault(goal.action, [])
        end = goal.ended if goal.ended is not None else now + 1e9
        row = next((number for number, busy in enumerate(rows) if busy <= goal.began - margin), len(rows))
        if row == len(rows):
            rows.append(end)
        else:
            rows[row] = end
        placed.append((goal, row))
    return placed
