"""The action server as a pure reactor: events in, effects out. No I/O, no threads, no clock.

    send_goal ─► on_goal_request ─► AskGoal ─► on_goal_decision ─► ReplyGoal, Accepted
    execute() ─► on_execute ─► PublishStatus, Execute ─► on_result ─► PublishStatus, ReplyResult…, WakeAt
    cancel_goal ─► on_cancel_request ─► AskCancel… ─► on_cancel_decision… ─► PublishStatus, ReplyCancel
    get_result ─► on_result_request ─► ReplyResult, now or when the goal has ended

Whoever drives it calls one method at a time (under a lock of its own), appends the effects to one queue and
performs them from there in order, one thread at a time and outside the lock. Then a status array is published
before the reply that relies on it, and transitions that come together share one array.

`now` and `stamp_ns` are times of the node's clock in nanoseconds, which may jump. Events about goals that are
no longer retained do nothing, since a user's goal handle may outlive the goal.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Generic

from goalwire.protocol.goals.cancel import Cancellation, choose
from goalwire.protocol.goals.effects import (
    Accepted,
    AskCancel,
    AskGoal,
    AssumedAborted,
    Execute,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    RequestT,
    ResultT,
    WakeAt,
)
from goalwire.protocol.goals.status import StatusArray
from goalwire.protocol.goals.table import GoalEvent, GoalStatus, after

if TYPE_CHECKING:
    from goalwire.protocol.goals.effects import ServerEffect
    from goalwire.protocol.goals.ids import GoalId

RESULT_TIMEOUT_NS = 10_000_000_000
"""How long results are kept (rcl_action's default)."""


@dataclass(slots=True)
class _Goal(Generic[RequestT, ResultT]):
    stamp_ns: int
    status: GoalStatus = GoalStatus.ACCEPTED
    started: bool = False
    ended: bool = False
    """True once status and result are both final."""
    result: ResultT | None = None
    waiting: list[RequestT] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class ServerStatistics:
    """How much a server holds at the moment."""

    deciding: int
    active: int
    retained: int
    cancellations: int
    waiting_for_results: int


class GoalServer(Generic[RequestT, ResultT]):
    """Every goal of one action server, from its request until its result is forgotten.

    `result_timeout_ns` after its end a goal is forgotten: at once for 0 (clients that wait already get the
    result), never for a negative one.
    """

    def __init__(self, result_timeout_ns: int = RESULT_TIMEOUT_NS) -> None:
        self._result_timeout_ns = result_timeout_ns
        self._deciding: dict[GoalId, RequestT] = {}
        self._goals: dict[GoalId, _Goal[RequestT, ResultT]] = {}
        self._cancellations: dict[int, Cancellation[RequestT]] = {}
        self._next_cancellation = 0
        self._expiring: list[tuple[int, GoalId]] = []
        """A heap: simulated time may go back, so the oldest result need not be the first to go."""
        self._statuses = StatusArray()
        self._closed = False

    # ---- what is known ----

    def status(self, goal_id: GoalId) -> GoalStatus:
        """Return where a goal stands; UNKNOWN where it is not retained."""
        goal = self._goals.get(goal_id)
        return GoalStatus.UNKNOWN if goal is None else goal.status

    def take_status(self) -> bytes | None:
        """Return the serialised status array to publish; None where nothing changed since the last."""
        return self._statuses.take()

    def statistics(self) -> ServerStatistics:
        """Count what is held."""
        goals = self._goals.values()
        return ServerStatistics(
            deciding=len(self._deciding),
            active=sum(goal.status.is_active for goal in goals),
            retained=len(goals),
            cancellations=len(self._cancellations),
            waiting_for_results=sum(len(goal.waiting) for goal in goals),
        )

    # ---- goals ----

    def on_goal_request(
        self, goal_id: GoalId, request: RequestT, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client sends a goal: [AskGoal], or [ReplyGoal] where its id is taken."""
        self._expire(now)
        if self._closed or goal_id in self._deciding or goal_id in self._goals:
            return [ReplyGoal(request, accepted=False, stamp_ns=0)]
        self._deciding[goal_id] = request
        return [AskGoal(goal_id)]

    def on_goal_decision(
        self, goal_id: GoalId, accepted: bool, stamp_ns: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """The user has decided (a failed callback has refused): [ReplyGoal, Accepted], or [ReplyGoal]."""
        if goal_id not in self._deciding:
            return []
        request = self._deciding.pop(goal_id)
        if not accepted:
            return [ReplyGoal(request, accepted=False, stamp_ns=0)]
        self._goals[goal_id] = _Goal(stamp_ns)
        self._statuses.add(goal_id, stamp_ns, GoalStatus.ACCEPTED)
        return [ReplyGoal(request, accepted=True, stamp_ns=stamp_ns), Accepted(goal_id)]

    def on_execute(self, goal_id: GoalId) -> list[ServerEffect[RequestT, ResultT]]:
        """The user wants the goal executed: [PublishStatus, Execute].

        A goal whose cancellation was accepted before stays CANCELING: [Execute]. Raises InvalidTransition
        for one that was executed before or has ended.
        """
        goal = self._goals.get(goal_id)
        if goal is None:
            return []
        if goal.status is GoalStatus.CANCELING and not goal.started:
            goal.started = True
            return [Execute(goal_id)]
        self._move(goal_id, goal, GoalEvent.EXECUTE)
        goal.started = True
        return [PublishStatus(), Execute(goal_id)]

    def on_event(self, goal_id: GoalId, event: GoalEvent, now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """The user ends the goal by SUCCEED, ABORT or CANCELED: [PublishStatus].

        The result follows with `on_result`. A goal that was never executed has none to wait for and gets the
        default: [PublishStatus, ReplyResult…, WakeAt]. Raises InvalidTransition.
        """
        goal = self._goals.get(goal_id)
        if goal is None:
            return []
        self._move(goal_id, goal, event)
        return [PublishStatus(), *([] if goal.started else self._end(goal_id, goal, None, now))]

    def on_result(
        self, goal_id: GoalId, result: ResultT | None, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """Execution is over, with its result (None: the default): [ReplyResult…, WakeAt].

        Where the user set no terminal state the goal is aborted: [AssumedAborted, PublishStatus,
        ReplyResult…, WakeAt].
        """
        goal = self._goals.get(goal_id)
        if goal is None or goal.ended:
            return []
        effects: list[ServerEffect[RequestT, ResultT]] = []
        if not goal.status.is_terminal:
            self._move(goal_id, goal, GoalEvent.ABORT)
            effects = [AssumedAborted(goal_id), PublishStatus()]
        return effects + self._end(goal_id, goal, result, now)

    def on_finish(
        self, goal_id: GoalId, event: GoalEvent, result: ResultT | None, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """End and result at once: [PublishStatus, ReplyResult…, WakeAt]. Raises InvalidTransition."""
        goal = self._goals.get(goal_id)
        if goal is None:
            return []
        self._move(goal_id, goal, event)
        return [PublishStatus(), *self._end(goal_id, goal, result, now)]

    # ---- cancelling ----

    def on_cancel_request(
        self, goal_id: GoalId, stamp_ns: int, request: RequestT, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client asks to cancel: [AskCancel…] in order of acceptance; [ReplyCancel] for nothing to ask."""
        self._expire(now)
        code, chosen = choose(self._goals, goal_id, stamp_ns)
        if not chosen:
            return [ReplyCancel(request, code, ())]
        number = self._next_cancellation
        self._next_cancellation += 1
        is_for_one = stamp_ns == 0 and chosen == (goal_id,)
        self._cancellations[number] = Cancellation(request, chosen, is_for_one)
        return [AskCancel(number, id_) for id_ in chosen]

    def on_cancel_decision(
        self, cancellation: int, goal_id: GoalId, accepted: bool
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """The user has decided about one goal (a callback that failed has refused).

        The goal is CANCELING at once. With the last decision: [PublishStatus, ReplyCancel], or
        [ReplyCancel] where no goal is cancelled.
        """
        open_one = self._cancellations.get(cancellation)
        if open_one is None or goal_id not in open_one.undecided:
            return []
        open_one.undecided.remove(goal_id)
        goal = self._goals.get(goal_id)
        if goal is None or not goal.status.is_cancelable:
            open_one.came_too_late = True
        elif accepted:
            self._move(goal_id, goal, GoalEvent.CANCEL_GOAL)
            open_one.canceling[goal_id] = goal.stamp_ns
        return [] if open_one.undecided else self._answer_cancellation(cancellation)

    def _answer_cancellation(self, number: int) -> list[ServerEffect[RequestT, ResultT]]:
        done = self._cancellations.pop(number)
        goals = tuple((id_, done.canceling[id_]) for id_ in done.goals if id_ in done.canceling)
        published: list[ServerEffect[RequestT, ResultT]] = [PublishStatus()] if goals else []
        return [*published, ReplyCancel(done.request, done.code, goals)]

    # ---- results ----

    def on_result_request(
        self, goal_id: GoalId, request: RequestT, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client asks for a result: [ReplyResult], or nothing until the goal has ended."""
        self._expire(now)
        goal = self._goals.get(goal_id)
        if goal is None:
            return [ReplyResult(request, GoalStatus.UNKNOWN, None)]
        if goal.ended:
            return [ReplyResult(request, goal.status, goal.result)]
        goal.waiting.append(request)
        return []

    def on_time(self, now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """The time of a WakeAt has come: forget what has expired; [WakeAt] where more is to come."""
        self._expire(now)
        return [WakeAt(self._expiring[0][0])] if self._expiring else []

    # ---- the end ----

    def on_close(self) -> list[ServerEffect[RequestT, ResultT]]:
        """The server goes away: every open request is answered, every active goal aborted.

        [ReplyGoal…, (PublishStatus,) ReplyCancel…, PublishStatus, ReplyResult…]; afterwards goals are
        refused.
        """
        self._closed = True
        effects: list[ServerEffect[RequestT, ResultT]] = []
        for goal_id in list(self._deciding):
            effects += self.on_goal_decision(goal_id, accepted=False, stamp_ns=0)
        for number in list(self._cancellations):
            effects += self._answer_cancellation(number)
        for goal_id, goal in self._goals.items():
            if goal.status is GoalStatus.ACCEPTED:
                self._move(goal_id, goal, GoalEvent.EXECUTE)
            if not goal.status.is_terminal:
                self._move(goal_id, goal, GoalEvent.ABORT)
        effects.append(PublishStatus())
        for goal in self._goals.values():
            effects += [ReplyResult(request, goal.status, goal.result) for request in goal.waiting]
        for goal_id in self._goals:
            self._statuses.remove(goal_id)
        self._goals.clear()
        self._expiring.clear()
        return effects

    # ---- the one place where goals change ----

    def _move(self, goal_id: GoalId, goal: _Goal[RequestT, ResultT], event: GoalEvent) -> None:
        goal.status = after(goal.status, event)
        self._statuses.update(goal_id, goal.status)

    def _end(
        self, goal_id: GoalId, goal: _Goal[RequestT, ResultT], result: ResultT | None, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """Status and result are final: answer who waits, and keep the result for its time."""
        goal.ended = True
        goal.result = result
        effects: list[ServerEffect[RequestT, ResultT]] = [
            ReplyResult(request, goal.status, result) for request in goal.waiting
        ]
        goal.waiting.clear()
        if self._result_timeout_ns == 0:
            self._forget(goal_id)
        elif self._result_timeout_ns > 0:
            expiry = (now + self._result_timeout_ns, goal_id)
            heappush(self._expiring, expiry)
            if self._expiring[0] is expiry:
                effects.append(WakeAt(expiry[0]))
        return effects

    def _expire(self, now: int) -> None:
        while self._expiring and self._expiring[0][0] <= now:
            self._forget(heappop(self._expiring)[1])

    def _forget(self, goal_id: GoalId) -> None:
        del self._goals[goal_id]
        self._statuses.remove(goal_id)
