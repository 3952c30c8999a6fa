"""What an action client keeps of its goals: the rules, and of each goal where it stands and its feedback."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING, Any

from goalwire.entities.actions.client_goal import ClientGoal
from goalwire.rules.goals.client import REMEMBERED, GoalClient

if TYPE_CHECKING:
    from goalwire.entities.actions.client_goal import FeedbackQueue
    from goalwire.entities.actions.requests import EncodedResponseFuture
    from goalwire.rules.goals.effects import ClientEffect
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.table import GoalStatus
    from goalwire.transport.contract import Payload

    Effects = list[ClientEffect[Any, EncodedResponseFuture, Payload]]


class ClientGoals:
    """The goals that are under way, and the latest of those that have ended or were lost.

    The latter still hear what was overtaken. Goals are looked up under no lock.
    """

    def __init__(self) -> None:
        self.lock = Lock()
        """Of the rules, and of what must change together with them."""
        self.rules: GoalClient[Any, EncodedResponseFuture, Payload] = GoalClient()
        self.active: dict[GoalId, ClientGoal] = {}
        self.ended: OrderedDict[GoalId, ClientGoal] = OrderedDict()
        self._dropped = 0

    def feed(self, event: Callable[..., Effects], *args: Any) -> Effects:
        """Tell one of the rules' events and return what follows from it."""
        with self.lock:
            return event(*args)

    def add(self, goal: ClientGoal) -> None:
        """A goal is about to be sent; raises GoalIdTaken."""
        with self.lock:
            self.rules.on_send(goal.goal_id)
            self.ended.pop(goal.goal_id, None)
            self.active[goal.goal_id] = goal

    def find(self, goal_id: GoalId) -> ClientGoal | None:
        """Return what is kept of a goal."""
        return self.active.get(goal_id) or self.ended.get(goal_id)

    def known(self, goal_id: GoalId) -> ClientGoal:
        """Return what is kept of a goal; something new where nothing is."""
        return self.find(goal_id) or ClientGoal(goal_id, None)

    def drop(self, goal_id: GoalId) -> None:
        """Keep nothing of a goal that no server has taken."""
        self.active.pop(goal_id, None)

    def advance(self, goal_id: GoalId, status: GoalStatus) -> None:
        """Note a goal's status."""
        goal = self.find(goal_id)
        if goal is None:
            return
        goal.advance(status)
        if status.is_terminal:
            self.forget(goal_id)

    def forget(self, goal_id: GoalId) -> None:
        """Keep a goal that has ended, or was lost, for feedback that was overtaken: the latest few."""
        with self.lock:
            goal = self.active.get(goal_id)
            if goal is None:
                return
            self.ended[goal_id] = goal  # first: feedback is looked up under no lock, here or there
            self.active.pop(goal_id, None)  # another thread may destroy the client meanwhile
            if len(self.ended) > REMEMBERED:
                self._dropped += self.ended.popitem(last=False)[1].dropped

    def make_room(self) -> bool:
        """Forget the oldest goal of which nobody asks the end; False where there is none."""
        with self.lock:
            crowded_out = self.rules.on_crowd()
        if crowded_out is None:
            return False
        self.forget(crowded_out)
        return True

    @property
    def feedback_queues(self) -> list[FeedbackQueue]:
        """Where the feedback of all these goals waits."""
        goals = (*self.active.copy().values(), *self.ended.copy().values())
        return [goal.feedback for goal in goals if goal.feedback is not None]

    @property
    def feedback_dropped(self) -> int:
        """How many feedback messages found their queue full."""
        with self.lock:
            return self._dropped + sum(queue.dropped for queue in self.feedback_queues)

    def close(self) -> None:
        """Take no more feedback and keep nothing."""
        for queue in self.feedback_queues:
            queue.close()
        self.active.clear()
        self.ended.clear()
