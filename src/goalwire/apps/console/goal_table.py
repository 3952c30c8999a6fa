"""The goals that are known: of every client, from the status and feedback topics of each action server."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

STATUSES = ('UNKNOWN', 'ACCEPTED', 'EXECUTING', 'CANCELING', 'SUCCEEDED', 'CANCELED', 'ABORTED')
"""By the number in action_msgs/msg/GoalStatus."""
ACTIVE = frozenset({'SENT', 'ACCEPTED', 'EXECUTING', 'CANCELING'})
KEPT = 300
"""Goals that are kept; of more, the ones that ended first are dropped."""
_TICKS = 400
_RISING = (
    'fraction_done',
    'progress',
    'percent',
    'percentage',
    'percent_complete',
    'fraction',
    'completion',
    'ratio',
)
_FALLING = ('remaining', '_left', 'to_go')


class TrackedGoal:
    """One goal, as far as it was seen from here. Times are readings of the monotonic clock, in s."""

    def __init__(self, action: str, goal_id: str, now: float) -> None:
        self.action = action
        self.goal_id = goal_id
        self.status = 'SENT'
        self.began = now
        self.ended: float | None = None
        self.accepted: float | None = None
        """By the server's clock, in s since 1970."""
        self.marks: list[tuple[float, str]] = []
        """When it came to each status."""
        self.ticks: deque[float] = deque(maxlen=_TICKS)
        """When feedback came."""
        self.feedback: Mapping[str, Any] | None = None
        self.progress: float | None = None
        """0 to 1, where the feedback tells."""
        self.result: Mapping[str, Any] | None = None
        self.problem = ''
        self.request: Mapping[str, Any] | None = None
        """What was sent, where it was from here."""
        self._first: dict[str, float] = {}

    @property
    def is_mine(self) -> bool:
        """Whether it was sent from this console."""
        return self.request is not None

    @property
    def is_active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ACTIVE

    def move(self, status: str, now: float) -> bool:
        """Note a status; False where it is no news, as one that comes after the goal's end.

        The answer to a goal may come behind the status that it runs: nothing becomes ACCEPTED again.
        """
        if status == self.status or not self.is_active or (status == 'ACCEPTED' and self.status != 'SENT'):
            return False
        self.status = status
        self.marks.append((now, status))
        if status not in ACTIVE:
            self.ended = now
            if status == 'SUCCEEDED' and self.progress is not None:
                self.progress = 1.0
        return True

    def take_feedback(self, feedback: Mapping[str, Any], now: float) -> None:
        """Note a feedback message."""
        self.ticks.append(now)
        self.feedback = feedback
        self.progress = self._progress_in(feedback, self.progress)

    def _progress_in(self, feedback: Mapping[str, Any], known: float | None) -> float | None:
        for name, value in feedback.items():
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if name in _RISING:
                return _bounded(value / 100 if name.startswith('percent') and value > 1 else value)
            if any(word in name for word in _FALLING):
                first = self._first.setdefault(name, float(value))
                return _bounded(1 - value / first) if first > 0 else 1.0
        return known


class GoalTable:
    """The goals of all actions, the latest last."""

    def __init__(self) -> None:
        self._goals: OrderedDict[tuple[str, str], TrackedGoal] = OrderedDict()
        self.version = 0
        """Another one after each change."""

    def __iter__(self) -> Iterator[TrackedGoal]:
        return iter(self._goals.values())

    def __len__(self) -> int:
        return len(self._goals)

    def get(self, action: str, goal_id: str) -> TrackedGoal | None:
        """Return a goal that is known."""
        return self._goals.get((action, goal_id))

    def active(self, action: str | None = None) -> list[TrackedGoal]:
        """Return the goals that have not ended."""
        return [goal for goal in self if goal.is_active and action in {None, goal.action}]

    def note_sent(self, action: str, goal_id: str, request: Mapping[str, Any], now: float) -> TrackedGoal:
        """Note a goal that is sent from here."""
        goal = self._goal(action, goal_id, now)
        goal.request = request
        return goal

    def take_statuses(
        self,
        action: str,
        statuses: Iterable[tuple[str, int, float]],
        now: float,
        wall_offset: float = 0.0,
    ) -> list[TrackedGoal]:
        """Note what a server says of its goals: id, number of the status, time of acceptance.

        That time is in s since 1970, and `wall_offset` is what leads there from readings such as `now`.
        Return those that have news. A goal that had ended when it was first seen ends when it
        began: no more is known.
        """
        news = []
        for goal_id, number, accepted in statuses:
            known = self._goals.get((action, goal_id))
            status = STATUSES[number] if 0 <= number < len(STATUSES) else 'UNKNOWN'
            is_old = known is None and status not in ACTIVE  # when it ended, nobody knows
            if known is None:
                began = min(now, accepted - wall_offset) if accepted > 0 else now
                known = self._goal(action, goal_id, began)
            known.accepted = accepted
            if known.move(status, known.began if is_old else now):
                news.append(known)
        return news

    def take_feedback(
        self, action: str, goal_id: str, feedback: Mapping[str, Any], now: float
    ) -> TrackedGoal:
        """Note feedback; the goal may be one that no status has told of yet."""
        goal = self._goal(action, goal_id, now)
        goal.take_feedback(feedback, now)
        self.version += 1
        return goal

    def end(self, goal: TrackedGoal, status: str, problem: str, now: float) -> None:
        """Note how a goal ended, where the server did not say it: it was refused, or the server is gone."""
        goal.problem = problem
        goal.move(status, now)
        self.version += 1

    def changed(self) -> None:
        """Say that a goal was changed from without."""
        self.version += 1

    def _goal(self, action: str, goal_id: str, now: float) -> TrackedGoal:
        key = (action, goal_id)
        goal = self._goals.get(key)
        if goal is None:
            goal = self._goals[key] = TrackedGoal(action, goal_id, now)
            self._drop_old()
        self.version += 1
        return goal

    def _drop_old(self) -> None:
        while len(self._goals) > KEPT:
            ended = next((key for key, goal in self._goals.items() if not goal.is_active), None)
            self._goals.pop(ended) if ended is not None else self._goals.popitem(last=False)


def lanes(goals: Iterable[TrackedGoal], now: float, margin: float = 0.0) -> list[tuple[TrackedGoal, int]]:
    """Give each goal the first row of its action in which the one before has ended, `margin` s earlier."""
    placed: list[tuple[TrackedGoal, int]] = []
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


def _bounded(number: float) -> float:
    return min(max(float(number), 0.0), 1.0)
