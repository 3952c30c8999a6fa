"""The action server as a reactor: events go in, effects come out. It has no I/O, no threads, and no clock.

    send_goal ─► on_goal_request ─► AskGoal ─► on_goal_decision ─► ReplyGoal, Accepted
    execute() ─► on_execute ─► PublishStatus, Execute ─► on_result ─► PublishStatus, ReplyResult…, WakeAt
    cancel_goal ─► on_cancel_request ─► AskCancel… ─► on_cancel_decision… ─► PublishStatus, ReplyCancel
    get_result ─► on_result_request ─► ReplyResult, now or when the goal has ended
    a client is gone ─► on_client_lost ─► PublishStatus, StoppedByServer
    with a journal: ─► KeepResult at the end, FindResult for requests about goals that do not run

There is one record of each goal: a ServerGoal in the server's GoalBook, from the request for the goal until
its result is discarded. Every event advances the record once. For the caller, the record also holds the
goal's handle and its execution until the goal has ended.

Under a policy other than UNLIMITED, on_execute may let a goal wait for its turn. When a goal ends, the
effects of its end come first, then [PublishStatus, Execute] of the goal whose turn it is.

The caller (entities/actions/server.py) holds its own lock, so that one method runs at a time. It appends
the effects to one queue and performs them in order, on one thread at a time and outside the lock. So a status
array is published before the reply that relies on it, and transitions that come together share one array.

`now` and `stamp_ns` are times of the node's clock in nanoseconds, which may jump. Events about goals that are
no longer retained do nothing, since a user's goal handle may outlive the goal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Generic

from goalwire.errors import InvalidTransition
from goalwire.rules.goals.cancel_requests import Cancellation, Cancellations, choose
from goalwire.rules.goals.effects import (
    Accepted,
    AskCancel,
    AskGoal,
    AssumedAborted,
    Execute,
    FindResult,
    KeepResult,
    PublishStatus,
    ReplyCancel,
    ReplyGoal,
    ReplyResult,
    RequestT,
    ResultT,
    StoppedByServer,
    WakeAt,
)
from goalwire.rules.goals.goal_book import RESULT_TIMEOUT_NS, GoalBook, ServerGoal
from goalwire.rules.goals.policy import UNLIMITED, GoalPolicy, check_policies
from goalwire.rules.goals.states import GoalEvent, GoalStatus

if TYPE_CHECKING:
    from goalwire.rules.goals.effects import ServerEffects
    from goalwire.rules.goals.goal_book import ServedGoals
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.journal import GoalJournal
    from goalwire.rules.goals.policy import OnClientLost

_EXECUTABLE = (GoalStatus.ACCEPTED, GoalStatus.CANCELING)
"""The states in which the first execution of a goal may begin."""


class GoalServer(Generic[RequestT, ResultT]):
    """Decides what happens to each goal of one action server, and to each request about a goal."""

    def __init__(
        self,
        result_timeout_ns: int = RESULT_TIMEOUT_NS,
        policy: GoalPolicy = UNLIMITED,
        on_client_lost: OnClientLost = 'keep',
        client_grace_ns: int = 0,
        journal: GoalJournal | None = None,
    ) -> None:
        """Make a server. GoalBook explains `result_timeout_ns`. Raises the errors of `check_policies`.

        If a client goes, the caller calls `on_client_gone` at once, `on_client_lost` after `client_grace_ns`.
        """
        check_policies(policy, on_client_lost)
        self._lost = on_client_lost
        self.client_grace_ns = client_grace_ns if on_client_lost != 'keep' else 0
        """The time for which another client may take over the goals of a lost client; 0: they end at once."""
        self.journal = journal
        self._book: GoalBook[RequestT, ResultT] = GoalBook(result_timeout_ns, policy)
        self._places = self._book.places
        self.policy = policy
        """The policy, which limits the goals that run at a time."""
        # The caller may read the following attributes, but not change them.
        self.deciding, self.goals = self._book.deciding, self._book.goals
        self.status, self.take_status = self._book.status, self._book.take_status
        self.on_client_gone = self._book.unfollow
        self._cancellations: Cancellations[RequestT] = Cancellations()
        self._closed = False

    # ---- questions about the goals ----

    @property
    def watches_clients(self) -> bool:
        """True if goals of lost clients are cancelled or aborted, so that clients must be watched."""
        return self._lost != 'keep'

    def statistics(self) -> ServedGoals:
        """Return the statistics of the goals and of open requests."""
        return self._book.statistics(cancellations=len(self._cancellations.open))

    # ---- goals ----

    def on_goal_request(
        self, goal_id: GoalId, request: RequestT, now: int, client: bytes = b''
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle a send_goal request: [AskGoal], or [ReplyGoal] if the id is taken or no place is free.

        `client` identifies the sender; on_client_lost gets the same value.
        """
        if self._book.expiring:
            self._book.expire(now)
        id_is_taken = goal_id in self.deciding or goal_id in self.goals
        if self._closed or id_is_taken or self._places.are_taken:
            return self._refuse(request)
        self.deciding[goal_id] = ServerGoal(goal_id, client, request)
        return [AskGoal(goal_id)]

    def on_goal_decision(
        self, goal_id: GoalId, accepted: bool, stamp_ns: int, handle: object = None
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle the user's decision: [ReplyGoal, Accepted], or [ReplyGoal] if the goal is refused.

        If the user's callback raised an error, pass a refusal. The goal is also refused if no place is free
        any more. `handle` is stored in the goal's record.
        """
        goal = self.deciding.pop(goal_id, None)
        if goal is None:
            return []
        request, goal.request = goal.request, None
        assert request is not None
        if not accepted or self._places.are_taken:
            return self._refuse(request)
        self._book.accept(goal, stamp_ns, handle)
        return [ReplyGoal(request, accepted=True, stamp_ns=stamp_ns), Accepted(goal_id)]

    def _refuse(self, request: RequestT) -> ServerEffects[RequestT, ResultT]:
        self._book.refuse()
        return [ReplyGoal(request, accepted=False, stamp_ns=0)]

    def on_execute(
        self, goal_id: GoalId, now: int, execution: object = None
    ) -> ServerEffects[RequestT, ResultT]:
        """Execute a goal: [PublishStatus, Execute], or [PublishStatus] if it has to wait for its turn.

        `execution` comes back with Execute. Under preempt() the earlier goals are cancelled: [PublishStatus,
        StoppedByServer]. If the goal is CANCELING, it keeps this state: [Execute]; or it ends, if it would
        have to wait. If the goal waits already, it goes on waiting: []. Raises InvalidTransition if the goal
        was executed earlier or has ended.
        """
        goal = self.goals.get(goal_id)
        if goal is None or goal_id in self._places.waiting:
            return []
        if goal.started or goal.status not in _EXECUTABLE:
            raise InvalidTransition(goal.status, GoalEvent.EXECUTE)
        goal.execution = execution
        if self._places.has_room:
            return self._start(goal)
        self._places.waiting[goal_id] = goal
        if goal.status is GoalStatus.CANCELING:
            return self._end_waiting(goal, now)
        return [PublishStatus(), *(self._preempt(goal, now) if self._places.policy.preempts else [])]

    def _start(self, goal: ServerGoal[RequestT, ResultT]) -> ServerEffects[RequestT, ResultT]:
        goal.started = True
        self._places.running += 1
        execute = Execute(goal.goal_id, goal.execution)
        goal.execution = None
        if goal.status is GoalStatus.CANCELING:
            return [execute]
        self._book.move(goal, GoalEvent.EXECUTE)
        return [PublishStatus(), execute]

    def _preempt(self, newest: ServerGoal[RequestT, ResultT], now: int) -> ServerEffects[RequestT, ResultT]:
        """Cancel every other goal that runs or waits for its turn, since `newest` preempts them."""
        effects: ServerEffects[RequestT, ResultT] = []
        for goal in list(self._places.unfinished.values()):
            if goal is not newest and (goal.started or goal.goal_id in self._places.waiting):
                effects += self._cancel(goal, now)
        return effects

    def on_event(self, goal_id: GoalId, event: GoalEvent, now: int) -> ServerEffects[RequestT, ResultT]:
        """End a goal by the user's SUCCEED, ABORT or CANCELED: [PublishStatus].

        The result follows by `on_result`. A goal that was never executed will not return a result, so it gets
        the default result: [PublishStatus, ReplyResult…, WakeAt]. Raises InvalidTransition.
        """
        goal = self.goals.get(goal_id)
        if goal is None:
            return []
        self._book.move(goal, event)
        return [PublishStatus(), *([] if goal.started else self._end(goal, None, now))]

    def on_result(
        self, goal_id: GoalId, result: ResultT | None, now: int
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle the end of a goal's execution and its result (None: the default): [ReplyResult…, WakeAt].

        If the user has set no terminal state, the goal is aborted: [AssumedAborted, PublishStatus,
        ReplyResult…, WakeAt].
        """
        goal = self.goals.get(goal_id)
        if goal is None or goal.ended:
            return []
        effects: ServerEffects[RequestT, ResultT] = []
        if not goal.status.is_terminal:
            self._book.move(goal, GoalEvent.ABORT)
            effects = [AssumedAborted(goal_id), PublishStatus()]
        return effects + self._end(goal, result, now)

    # ---- cancelling ----

    def on_cancel_request(
        self, goal_id: GoalId, stamp_ns: int, request: RequestT, now: int
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle a cancel_goal request: [AskCancel…], one for each goal, or [ReplyCancel] if no goal fits."""
        if self._book.expiring:
            self._book.expire(now)
        code, chosen = choose(self.goals, goal_id, stamp_ns)
        if not chosen:
            return [ReplyCancel(request, code, ())]
        is_for_one = stamp_ns == 0 and chosen == (goal_id,)
        number = self._cancellations.add(Cancellation(request, chosen, is_for_one=is_for_one))
        return [AskCancel(number, id_) for id_ in chosen]

    def on_cancel_decision(
        self, cancellation: int, goal_id: GoalId, accepted: bool, now: int
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle the user's decision about cancelling one goal. Pass a refusal if the callback raised.

        An accepted cancellation makes the goal CANCELING at once, or CANCELED if it waits for its turn:
        [PublishStatus, ReplyResult…, WakeAt]. The last decision of the request adds [PublishStatus,
        ReplyCancel], or [ReplyCancel] if no goal is cancelled.
        """
        open_one = self._cancellations.take_decision(cancellation, goal_id)
        if open_one is None:
            return []
        effects: ServerEffects[RequestT, ResultT] = []
        goal = self.goals.get(goal_id)
        if goal is None or not goal.status.is_cancelable:
            open_one.came_too_late = True
        elif accepted:
            open_one.canceling[goal_id] = goal.stamp_ns
            self._book.move(goal, GoalEvent.CANCEL_GOAL)
            if goal_id in self._places.waiting:
                effects = self._end_waiting(goal, now)
        return effects if open_one.undecided else effects + self._answer_cancellation(cancellation)

    def _answer_cancellation(self, number: int) -> ServerEffects[RequestT, ResultT]:
        done = self._cancellations.open.pop(number)
        granted = done.granted
        return [*([PublishStatus()] if granted else []), ReplyCancel(done.request, done.code, granted)]

    def _cancel(self, goal: ServerGoal[RequestT, ResultT], now: int) -> ServerEffects[RequestT, ResultT]:
        """Cancel a goal without a client's request. Does nothing if the goal is being cancelled already."""
        if not goal.status.is_cancelable:
            return []
        self._book.move(goal, GoalEvent.CANCEL_GOAL)
        if goal.goal_id in self._places.waiting:
            return self._end_waiting(goal, now)
        return [PublishStatus(), StoppedByServer(goal.goal_id)]

    def _end_waiting(self, goal: ServerGoal[RequestT, ResultT], now: int) -> ServerEffects[RequestT, ResultT]:
        """End a goal that became CANCELING while it waited for its turn."""
        self._book.move(goal, GoalEvent.CANCELED)
        return [PublishStatus(), *self._end(goal, None, now)]

    # ---- clients ----

    def on_client_lost(self, client: bytes, now: int) -> ServerEffects[RequestT, ResultT]:
        """Keep, cancel or abort the goals of a client that has gone, as the server's setting says.

        Goals that the user has not decided about are refused: [ReplyGoal…]. For the other goals:
        [PublishStatus, StoppedByServer…], or the effects of their end if they do not run.
        """
        effects: ServerEffects[RequestT, ResultT] = []
        if self._lost == 'keep':
            return effects
        for goal in list(self.deciding.values()):
            if goal.client == client:
                effects += self.on_goal_decision(goal.goal_id, accepted=False, stamp_ns=0)
        end = self._cancel if self._lost == 'cancel' else self._abort
        for goal in self._book.orphans(client):
            effects += end(goal, now)
        return effects

    def _abort(self, goal: ServerGoal[RequestT, ResultT], now: int) -> ServerEffects[RequestT, ResultT]:
        """Abort a goal in any active state. Does nothing if the goal has ended."""
        if goal.status.is_terminal:
            return []
        self._book.abort(goal)
        if goal.started:
            return [PublishStatus(), StoppedByServer(goal.goal_id)]
        return [PublishStatus(), *self._end(goal, None, now)]

    # ---- results ----

    def on_result_request(
        self, goal_id: GoalId, request: RequestT, now: int, client: bytes = b''
    ) -> ServerEffects[RequestT, ResultT]:
        """Handle a get_result request: [ReplyResult] or [FindResult] if the goal has ended, else []."""
        if self._book.expiring:
            self._book.expire(now)
        goal = self.goals.get(goal_id)
        if self.journal is not None and (goal is None or goal.ended):
            return [FindResult(request, goal_id)]
        if goal is None:
            return [ReplyResult(request, GoalStatus.UNKNOWN, None)]
        if goal.ended:
            return [ReplyResult(request, goal.status, goal.result)]
        goal.waiting.append(request)
        if self.client_grace_ns:
            goal.followers.add(client)
        return []

    def on_time(self, now: int) -> ServerEffects[RequestT, ResultT]:
        """Discard the results that have expired when a WakeAt is due: [WakeAt] if other results are left."""
        book = self._book
        book.expire(now)
        return [WakeAt(book.expiring[0][0])] if book.expiring else []

    # ---- the end of the server ----

    def on_close(self, leaves_goals: bool = False) -> ServerEffects[RequestT, ResultT]:
        """Answer every open request and abort every active goal, since the server is being destroyed.

        [ReplyGoal…, (PublishStatus,) ReplyCancel…, PublishStatus, ReplyResult…]. Later goals are refused. If
        the server leaves its goals, which go on elsewhere, none is aborted, and no result is sent.
        """
        self._closed = True
        self._places.clear()
        effects: ServerEffects[RequestT, ResultT] = []
        for goal_id in list(self.deciding):
            effects += self.on_goal_decision(goal_id, accepted=False, stamp_ns=0)
        for number in list(self._cancellations.open):
            effects += self._answer_cancellation(number)
        effects += [] if leaves_goals else [PublishStatus()]
        for goal in list(self.goals.values()):
            if not (leaves_goals or goal.status.is_terminal):
                self._book.abort(goal)
            if not (leaves_goals or goal.ended):
                effects += _tell_result(goal, goal.result, self.journal)
            self._book.discard(goal)
        self._book.expiring.clear()
        return effects

    # ---- the end of a goal ----

    def _end(
        self, goal: ServerGoal[RequestT, ResultT], result: ResultT | None, now: int
    ) -> ServerEffects[RequestT, ResultT]:
        """End a goal: answer the requests for its result, and start goals that wait for their turn."""
        effects = _tell_result(goal, result, self.journal)
        expiry = self._book.finish(goal, result, now)
        if expiry is not None:
            effects.append(WakeAt(expiry))
        while self._places.waiting and (following := self._places.next()) is not None:
            effects += self._start(following)
        return effects


def _tell_result(
    goal: ServerGoal[RequestT, ResultT], result: ResultT | None, journal: GoalJournal | None
) -> ServerEffects[RequestT, ResultT]:
    """Answer the requests that wait for a goal's result; with a journal, write the result there first."""
    requests = tuple(goal.waiting)
    goal.waiting.clear()
    if journal is not None:
        return [KeepResult(goal.goal_id, goal.status, result, requests)]
    return [ReplyResult(request, goal.status, result) for request in requests]
