"""The action client as a pure reactor: which goals are ours, where they stand, who waits for what.

    on_send ─► on_goal_reply ─► GoalAccepted or GoalRejected
    on_feedback ─► DeliverFeedback           (from the moment the goal is sent)
    on_status ─► StatusChanged…              (forward only, never out of a terminal state)
    on_result_request ─► RequestResult ─► on_result ─► DeliverResult…

Replies, feedback, statuses and results travel on different ways and may come in any order: nothing is lost
that arrives before the acceptance is known. A goal is forgotten when it has ended, or its server was
lost, and nobody waits for its result; the latest of these still hear what was overtaken. Effects are
performed in order.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic

from goalwire.errors import GoalIdTaken
from goalwire.rules.goals.effects import (
    DeliverFeedback,
    DeliverResult,
    FailResult,
    FeedbackT,
    GoalAccepted,
    GoalRejected,
    RequestResult,
    ResultT,
    StatusChanged,
    UnexpectedReply,
    WaiterT,
)
from goalwire.rules.goals.table import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Iterable

    from goalwire.rules.goals.effects import ClientEffect
    from goalwire.rules.goals.ids import GoalId

REMEMBERED = 128
"""How many goals that have ended, or whose server was lost, still get late feedback and statuses."""


@dataclass(slots=True)
class _Goal(Generic[WaiterT]):
    answered: bool = False
    """True once the reply to send_goal has come."""
    status: GoalStatus = GoalStatus.UNKNOWN
    waiters: list[WaiterT] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class SentGoals:
    """How much a client holds at the moment, and how many goals it has had."""

    unanswered: int
    active: int
    """Accepted, and not known to have ended."""
    remembered: int
    """Ended; these still hear what was overtaken."""
    waiting_for_results: int
    sent: int
    accepted: int
    refused: int
    succeeded: int
    canceled: int
    aborted: int


class GoalClient(Generic[FeedbackT, WaiterT, ResultT]):
    """Every goal that one action client has under way. A waiter is what the driver completes in the end."""

    def __init__(self) -> None:
        self._goals: dict[GoalId, _Goal[WaiterT]] = {}
        self._ended: OrderedDict[GoalId, GoalStatus] = OrderedDict()
        self._lost: set[GoalId] = set()
        """Those of `_ended` of which no end is known."""
        self._sent = self._accepted = self._refused = 0
        self._reached = [0] * len(GoalStatus)
        """How many goals have come to each status."""

    def status(self, goal_id: GoalId) -> GoalStatus:
        """Return the last that was heard of a goal; UNKNOWN for one that is forgotten."""
        goal = self._goals.get(goal_id)
        return self._ended.get(goal_id, GoalStatus.UNKNOWN) if goal is None else goal.status

    def statistics(self) -> SentGoals:
        """Count what is held."""
        goals = self._goals.values()
        return SentGoals(
            unanswered=sum(not goal.answered for goal in goals),
            active=sum(goal.answered for goal in goals),
            remembered=len(self._ended),
            waiting_for_results=sum(len(goal.waiters) for goal in goals),
            sent=self._sent,
            accepted=self._accepted,
            refused=self._refused,
            succeeded=self._reached[GoalStatus.SUCCEEDED],
            canceled=self._reached[GoalStatus.CANCELED],
            aborted=self._reached[GoalStatus.ABORTED],
        )

    # ---- sending ----

    def on_send(self, goal_id: GoalId) -> None:
        """A goal is about to be sent; raises GoalIdTaken. Call it before the request goes out."""
        if goal_id in self._goals:
            raise GoalIdTaken(goal_id)
        self._recall(goal_id)
        self._goals[goal_id] = _Goal()
        self._sent += 1

    def on_goal_reply(
        self, goal_id: GoalId, accepted: bool
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """The server has answered: [GoalAccepted], [GoalRejected], or [UnexpectedReply]."""
        goal = self._goals.get(goal_id)
        if goal is None or goal.answered:
            return [UnexpectedReply(goal_id)]
        goal.answered = True
        if not accepted:
            self._refused += 1
            if not goal.waiters:  # else one who holds an older goal of this id has asked: an answer will come
                del self._goals[goal_id]
            return [GoalRejected(goal_id)]
        self._accepted += 1
        self._forget_if_over(goal_id, goal)
        return [GoalAccepted(goal_id, goal.status)]

    def on_send_failed(
        self, goal_id: GoalId, error: Exception
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """No answer will come, or nobody waits for it any more: [FailResult…]."""
        goal = self._goals.pop(goal_id, None)
        return [] if goal is None else [FailResult(waiter, error) for waiter in goal.waiters]

    def on_crowd(self) -> GoalId | None:
        """Forget the oldest accepted goal whose end nobody asks for; None where there is none."""
        for goal_id, goal in self._goals.items():
            if goal.answered and not goal.waiters:
                self._forget_if_over(goal_id, goal, at_any_status=True)
                return goal_id
        return None

    # ---- what the server tells on its own ----

    def on_feedback(
        self, goal_id: GoalId, feedback: FeedbackT
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """Feedback has come: [DeliverFeedback], or nothing for somebody else's goal."""
        ours = goal_id in self._goals or goal_id in self._ended
        return [DeliverFeedback(goal_id, feedback)] if ours else []

    def followed(self) -> set[GoalId]:
        """Return the goals of which a status array may still tell something."""
        return self._lost.union(self._goals)

    def on_status(
        self, statuses: Iterable[tuple[GoalId, GoalStatus]]
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """A status array has come: [StatusChanged…] for those of our goals that have moved on."""
        effects: list[ClientEffect[FeedbackT, WaiterT, ResultT]] = []
        for goal_id, status in statuses:
            goal = self._goals.get(goal_id)
            if goal is not None:
                effects += self._advance(goal_id, goal, status)
                self._forget_if_over(goal_id, goal)
            elif _moves_on(self._ended.get(goal_id, GoalStatus.ABORTED), status):
                self._ended[goal_id] = status
                if status.is_terminal:
                    self._lost.discard(goal_id)
                self._reached[status] += 1
                effects.append(StatusChanged(goal_id, status))
        return effects

    # ---- results ----

    def on_result_request(
        self, goal_id: GoalId, waiter: WaiterT
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """Somebody wants the result: [RequestResult], or nothing where the request is under way already."""
        goal = self._goals.get(goal_id)
        if goal is None:
            goal = _Goal(answered=True, status=self._recall(goal_id))
            self._goals[goal_id] = goal
        goal.waiters.append(waiter)
        return [RequestResult(goal_id)] if len(goal.waiters) == 1 else []

    def on_result(
        self, goal_id: GoalId, status: GoalStatus, result: ResultT
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """The result has come: ([StatusChanged],) [DeliverResult…].

        A status of UNKNOWN means that the server no longer knows the goal.
        """
        goal = self._goals.get(goal_id)
        if goal is None:
            return []
        effects = self._advance(goal_id, goal, status)
        effects += [DeliverResult(waiter, status, result) for waiter in goal.waiters]
        goal.waiters.clear()
        self._forget_if_over(goal_id, goal, at_any_status=True)
        return effects

    def on_result_failed(
        self, goal_id: GoalId, error: Exception
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """The request for the result has failed: [FailResult…].

        The goal itself may well go on; but where its server was killed, nothing ever tells its end.
        """
        goal = self._goals.get(goal_id)
        if goal is None:
            return []
        effects: list[ClientEffect[FeedbackT, WaiterT, ResultT]] = [
            FailResult(waiter, error) for waiter in goal.waiters
        ]
        goal.waiters.clear()
        self._forget_if_over(goal_id, goal, at_any_status=True)
        return effects

    def on_result_given_up(self, goal_id: GoalId, waiter: WaiterT) -> bool:
        """One who wanted the result waits no longer; True where nobody is left for whom it was asked."""
        goal = self._goals.get(goal_id)
        if goal is None or waiter not in goal.waiters:
            return False
        goal.waiters.remove(waiter)
        self._forget_if_over(goal_id, goal, at_any_status=True)
        return not goal.waiters

    def wants_result(self, goal_id: GoalId) -> bool:
        """Whether somebody waits for a goal's result."""
        goal = self._goals.get(goal_id)
        return goal is not None and bool(goal.waiters)

    def on_close(self, error: Exception) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        """The client goes away: [FailResult…] for all who wait."""
        waiters = [waiter for goal in self._goals.values() for waiter in goal.waiters]
        self._goals.clear()
        self._ended.clear()
        self._lost.clear()
        return [FailResult(waiter, error) for waiter in waiters]

    # ---- what they share ----

    def _advance(
        self, goal_id: GoalId, goal: _Goal[WaiterT], status: GoalStatus
    ) -> list[ClientEffect[FeedbackT, WaiterT, ResultT]]:
        if not _moves_on(goal.status, status):
            return []
        goal.status = status
        self._reached[status] += 1
        return [StatusChanged(goal_id, status)]

    def _forget_if_over(self, goal_id: GoalId, goal: _Goal[WaiterT], *, at_any_status: bool = False) -> None:
        if goal.waiters or not goal.answered or not (goal.status.is_terminal or at_any_status):
            return
        del self._goals[goal_id]
        self._ended[goal_id] = goal.status
        if not goal.status.is_terminal:
            self._lost.add(goal_id)
        if len(self._ended) > REMEMBERED:
            self._lost.discard(self._ended.popitem(last=False)[0])

    def _recall(self, goal_id: GoalId) -> GoalStatus:
        """Take a goal off those that are only remembered; return where it stood."""
        self._lost.discard(goal_id)
        return self._ended.pop(goal_id, GoalStatus.UNKNOWN)


def _moves_on(before: GoalStatus, after: GoalStatus) -> bool:
    # The numbers grow along every path of the table, up to the first terminal state.
    return not before.is_terminal and after > before
