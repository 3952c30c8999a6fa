"""The action client as a reactor without I/O: the goals that it has sent, their states, and their waiters.

    on_send ─► on_goal_reply ─► GoalAccepted or GoalRejected
    on_status ─► StatusChanged…              (forward only, never out of a terminal state)
    on_result_request ─► RequestResult ─► on_result ─► DeliverResult…

There is one record of each goal: a ClientGoal, in `active` or in `ended`. Every event advances the record
once. Feedback does not change a goal's state, so there is no event for feedback. It goes to the queue that
the record holds from the moment the goal is sent.

Replies, feedback, statuses and results travel on different topics and services and may come in any order.
Messages that arrive before the acceptance is known are not lost. A goal moves from `active` to `ended` when
it has ended, or its server was lost, and nobody waits for its result. The latest goals in `ended` still take
late messages.

The caller holds a lock of its own, so that one method runs at a time, and performs the effects in order.
Records may be read without the lock.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Generic, Protocol

from goalwire.errors import GoalIdTaken
from goalwire.records import record
from goalwire.rules.goals.effects import (
    DeliverResult,
    FailResult,
    GoalAccepted,
    GoalRejected,
    RequestResult,
    ResultT,
    StatusChanged,
    UnexpectedReply,
    WaiterT,
)
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.goals.status_array import statuses_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.rules.goals.effects import ClientEffect
    from goalwire.rules.goals.ids import GoalId

REMEMBERED = 128
"""How many goals are kept for late feedback and statuses after the end of the goal or of its server."""


class FeedbackQueue(Protocol):
    """The queue in which the feedback of one goal waits."""

    def deliver(self, event: Any, /) -> object:
        """Queue a message in its serialized form from the wire. Any thread may call this."""

    def close(self) -> None:
        """Discard the waiting feedback, and refuse further feedback."""

    @property
    def dropped(self) -> int:
        """The number of messages that found the queue full."""


class ClientGoal(Generic[WaiterT]):
    """A client's record of one goal.

    Only the reactor changes it, except for the fields marked as the caller's.
    """

    __slots__ = (
        'answered',
        'feedback',
        'goal_id',
        'heard',
        'reason',
        'request',
        'sent_at',
        'status',
        'waiters',
    )

    def __init__(self, goal_id: GoalId, feedback: FeedbackQueue | None = None, sent_at: int = 0) -> None:
        self.goal_id = goal_id
        self.feedback = feedback
        """The queue of its feedback; None if the user takes none."""
        self.sent_at = sent_at
        """The time of sending, in ns since the UNIX epoch; 0 if another client has sent it."""
        self.answered = False
        """True once a server has accepted or refused it."""
        self.status = GoalStatus.UNKNOWN
        """The latest known status. It only moves forward, and a terminal status is final."""
        self.waiters: list[WaiterT] = []
        """The waiters for its result, as the caller passed them."""
        self.request: Any = None
        """Belongs to the caller: the request for the result that is not answered yet."""
        self.reason = ''
        """Belongs to the caller: why the goal was aborted, if the server is goalwire's and has
        sent a reason.
        """
        self.heard: Callable[[], object] | None = None
        """Belongs to the caller: a function to be called at each feedback and each change of the status."""


@record
class SentGoals:
    """How many goals a client has now, and has had so far."""

    unanswered: int
    active: int
    """Goals that were accepted, and are not known to have ended."""
    remembered: int
    """Goals that have ended, and still take late messages."""
    waiting_for_results: int
    sent: int
    accepted: int
    refused: int
    succeeded: int
    canceled: int
    aborted: int


class GoalClient(Generic[WaiterT, ResultT]):
    """The goals of one action client. The caller completes each waiter when an effect says so."""

    def __init__(self) -> None:
        self.active: dict[GoalId, ClientGoal[WaiterT]] = {}
        """Goals that have not ended, or for whose results a waiter waits."""
        self.ended: OrderedDict[GoalId, ClientGoal[WaiterT]] = OrderedDict()
        """The latest goals that left `active`, the oldest first."""
        self._lost: set[GoalId] = set()
        """The goals in `ended` of which no terminal status has come."""
        self._feedback_dropped = 0
        self._sent = self._accepted = self._refused = 0
        self._reached = [0] * len(GoalStatus)
        """The number of goals that have reached each status."""

    def find(self, goal_id: GoalId) -> ClientGoal[WaiterT] | None:
        """Return the record of a goal; None if the client has no record of it."""
        return self.active.get(goal_id) or self.ended.get(goal_id)

    def status(self, goal_id: GoalId) -> GoalStatus:
        """Return the last known status of a goal; UNKNOWN for a goal without a record."""
        goal = self.find(goal_id)
        return GoalStatus.UNKNOWN if goal is None else goal.status

    def feedback_queues(self) -> list[FeedbackQueue]:
        """Return the queues of the goals' feedback."""
        goals = (*self.active.copy().values(), *self.ended.copy().values())
        return [goal.feedback for goal in goals if goal.feedback is not None]

    @property
    def feedback_dropped(self) -> int:
        """The number of feedback messages that found their queue full."""
        return self._feedback_dropped + sum(queue.dropped for queue in self.feedback_queues())

    def statistics(self) -> SentGoals:
        """Count the goals and their requests."""
        goals = self.active.values()
        return SentGoals(
            unanswered=sum(not goal.answered for goal in goals),
            active=sum(goal.answered for goal in goals),
            remembered=len(self.ended),
            waiting_for_results=sum(len(goal.waiters) for goal in goals),
            sent=self._sent,
            accepted=self._accepted,
            refused=self._refused,
            succeeded=self._reached[GoalStatus.SUCCEEDED],
            canceled=self._reached[GoalStatus.CANCELED],
            aborted=self._reached[GoalStatus.ABORTED],
        )

    # ---- sending ----

    def on_send(
        self, goal_id: GoalId, feedback: FeedbackQueue | None = None, sent_at: int = 0
    ) -> ClientGoal[WaiterT]:
        """Record a goal. Call this before the goal's request is sent. Raises GoalIdTaken."""
        if goal_id in self.active:
            raise GoalIdTaken(goal_id)
        goal: ClientGoal[WaiterT] = ClientGoal(goal_id, feedback, sent_at)
        self.active[goal_id] = goal
        if goal_id in self.ended:
            self._recall(goal_id)
        self._sent += 1
        return goal

    def on_goal_reply(self, goal_id: GoalId, accepted: bool) -> list[ClientEffect[WaiterT, ResultT]]:
        """Handle the server's answer to a goal: [GoalAccepted], [GoalRejected], or [UnexpectedReply]."""
        goal = self.active.get(goal_id)
        if goal is None or goal.answered:
            return [UnexpectedReply(goal_id)]
        goal.answered = True
        if not accepted:
            self._refused += 1
            if not goal.waiters:  # somebody may wait for the result of an earlier goal with this id
                del self.active[goal_id]
            return [GoalRejected(goal_id)]
        self._accepted += 1
        if goal.status.is_terminal and not goal.waiters:
            self._put_away(goal)
        return [GoalAccepted(goal_id, goal.status)]

    def on_send_failed(self, goal_id: GoalId, error: Exception) -> list[ClientEffect[WaiterT, ResultT]]:
        """Forget a goal whose send_goal request gets no answer, or is not awaited any more: [FailResult…]."""
        goal = self.active.pop(goal_id, None)
        return [] if goal is None else self._fail_waiters(goal, error)

    def on_crowd(self) -> bool:
        """Move the oldest accepted goal without waiters to `ended`, to make room; False if there is none."""
        for goal in self.active.values():
            if goal.answered and not goal.waiters:
                self._put_away(goal)
                return True
        return False

    # ---- goals that were sent earlier ----

    def on_follow(self, goal_id: GoalId, feedback: FeedbackQueue) -> ClientGoal[WaiterT]:
        """Record a goal that this or another client has sent before. No request is sent.

        Raises GoalIdTaken if this client follows the goal already, or awaits the answer to its request.
        """
        goal = self.active.get(goal_id)
        if goal is not None and (goal.feedback is not None or not goal.answered):
            raise GoalIdTaken(goal_id, 'is followed by this client already: leave that block first')
        goal = goal or self.ended.get(goal_id) or ClientGoal(goal_id)
        if goal.feedback is not None:
            self._feedback_dropped += goal.feedback.dropped
        goal.feedback = feedback
        goal.answered = True
        # Added before `_recall` takes it out of `ended`: threads without the lock always find the goal.
        self.active[goal_id] = goal
        self._recall(goal_id)
        return goal

    # ---- status arrays, which the server sends unasked ----

    def on_status(self, payload: bytes) -> list[ClientEffect[WaiterT, ResultT]]:
        """Handle a status array: [StatusChanged…] for the goals of this client whose status has changed.

        Raises RemoteError for an array that cannot be read.
        """
        effects: list[ClientEffect[WaiterT, ResultT]] = []
        followed = self._lost.union(self.active) if self._lost else self.active
        for goal_id, status in statuses_of(followed, payload):
            goal = self.active.get(goal_id) or self.ended[goal_id]
            effects += self._advance(goal, status)
            if status.is_terminal:
                self._lost.discard(goal_id)
                if goal.answered and not goal.waiters and goal_id in self.active:
                    self._put_away(goal)
        return effects

    # ---- results ----

    def on_result_request(self, goal_id: GoalId, waiter: WaiterT) -> list[ClientEffect[WaiterT, ResultT]]:
        """Add a waiter for a goal's result: [RequestResult], or [] if the result was requested already."""
        goal = self.active.get(goal_id)
        if goal is None:
            goal = self.ended.get(goal_id) or ClientGoal(goal_id)
            goal.answered = True
            # Added before `_recall` takes it out of `ended`: threads without the lock always find the goal.
            self.active[goal_id] = goal
            self._recall(goal_id)
        goal.waiters.append(waiter)
        return [RequestResult(goal_id)] if len(goal.waiters) == 1 else []

    def on_result(
        self, goal_id: GoalId, status: GoalStatus, result: ResultT
    ) -> list[ClientEffect[WaiterT, ResultT]]:
        """Handle a goal's result: [StatusChanged] if the status is new, then [DeliverResult…].

        A status of UNKNOWN means that the server does not know the goal any more.
        """
        goal = self.active.get(goal_id)
        if goal is None:
            return []
        effects = self._advance(goal, status)
        for waiter in goal.waiters:
            effects.append(DeliverResult(waiter, status, result))
        goal.waiters.clear()
        goal.request = None
        if goal.answered:
            self._put_away(goal)
        return effects

    def on_result_failed(self, goal_id: GoalId, error: Exception) -> list[ClientEffect[WaiterT, ResultT]]:
        """Handle the failure of a get_result request: [FailResult…].

        The goal itself may go on. But if its server was killed, no message tells the goal's end, so the goal
        goes to `ended`.
        """
        goal = self.active.get(goal_id)
        if goal is None:
            return []
        effects = self._fail_waiters(goal, error)
        goal.request = None
        if goal.answered:
            self._put_away(goal)
        return effects

    def on_result_cancelled(self, goal_id: GoalId, waiter: WaiterT) -> Any:
        """Remove a waiter. If it was the last, return the get_result request, for the caller to cancel."""
        goal = self.active.get(goal_id)
        if goal is None or waiter not in goal.waiters:
            return None
        goal.waiters.remove(waiter)
        if goal.waiters:
            return None
        request, goal.request = goal.request, None
        if goal.answered:
            self._put_away(goal)
        return request

    def on_close(self, error: Exception) -> list[ClientEffect[WaiterT, ResultT]]:
        """Fail all waiters, since the client is being destroyed: [FailResult…]."""
        effects = [effect for goal in self.active.values() for effect in self._fail_waiters(goal, error)]
        self.active.clear()
        self.ended.clear()
        self._lost.clear()
        return effects

    # ---- helpers of the event methods ----

    def _advance(self, goal: ClientGoal[WaiterT], status: GoalStatus) -> list[ClientEffect[WaiterT, ResultT]]:
        # Along every path of the table of transitions the numbers of the states grow up to the terminal
        # state. So a status that comes late has a lower number than the present status.
        if goal.status.is_terminal or status <= goal.status:
            return []
        goal.status = status
        self._reached[status] += 1
        return [StatusChanged(goal.goal_id, status)]

    def _fail_waiters(
        self, goal: ClientGoal[WaiterT], error: Exception
    ) -> list[ClientEffect[WaiterT, ResultT]]:
        waiters = goal.waiters.copy()
        goal.waiters.clear()
        return [FailResult(waiter, error) for waiter in waiters]

    def _put_away(self, goal: ClientGoal[WaiterT]) -> None:
        """Move a goal that has ended or was lost to `ended`, where it still takes late messages.

        Only the latest REMEMBERED goals are kept there.
        """
        goal_id = goal.goal_id
        # Added before it is taken out of `active`: threads without the lock always find the goal.
        self.ended[goal_id] = goal
        del self.active[goal_id]
        if not goal.status.is_terminal:
            self._lost.add(goal_id)
        if len(self.ended) > REMEMBERED:
            oldest, discarded = self.ended.popitem(last=False)
            self._lost.discard(oldest)
            if discarded.feedback is not None:
                self._feedback_dropped += discarded.feedback.dropped

    def _recall(self, goal_id: GoalId) -> None:
        """Remove a goal from `ended`."""
        self.ended.pop(goal_id, None)
        self._lost.discard(goal_id)
