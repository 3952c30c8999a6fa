"""The action server as a pure reactor: events in, effects out. No I/O, no threads, no clock.

    send_goal ─► on_goal_request ─► AskGoal ─► on_goal_decision ─► ReplyGoal, Accepted
    execute() ─► on_execute ─► PublishStatus, Execute ─► on_result ─► PublishStatus, ReplyResult…, WakeAt
    cancel_goal ─► on_cancel_request ─► AskCancel… ─► on_cancel_decision… ─► PublishStatus, ReplyCancel
    get_result ─► on_result_request ─► ReplyResult, now or when the goal has ended
    a client is gone ─► on_client_lost ─► PublishStatus, StoppedByServer

There is one record of each goal: a ServerGoal, from the request for the goal until its result is discarded.
Every event advances it once. The record also holds two things for the caller, the goal's handle and its
execution, until the goal has ended.

Under a policy other than UNLIMITED, on_execute may let a goal wait for its turn. When another goal ends, the
effects of that end come first, then [PublishStatus, Execute] of the goal whose turn it is.

The caller (entities/actions/server.py) holds a lock of its own, so that one method runs at a time. It appends
the effects to one queue and performs them in order, on one thread at a time and outside the lock. So a status
array is published before the reply that relies on it, and transitions that come together share one array.

`now` and `stamp_ns` are times of the node's clock in nanoseconds, which may jump. Events about goals that are
no longer retained do nothing, since a user's goal handle may outlive the goal.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any, Generic

from goalwire.errors import InvalidTransition
from goalwire.records import record
from goalwire.rules.goals.cancel import Cancellation, choose
from goalwire.rules.goals.effects import (
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
    StoppedByServer,
    WakeAt,
)
from goalwire.rules.goals.policy import ON_CLIENT_LOST, UNLIMITED, GoalPolicy, Places
from goalwire.rules.goals.status import StatusArray
from goalwire.rules.goals.table import GoalEvent, GoalStatus, after

if TYPE_CHECKING:
    from goalwire.rules.goals.effects import ServerEffect
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.policy import OnClientLost

RESULT_TIMEOUT_NS = 10_000_000_000
"""How long results are kept (rcl_action's default)."""

_EXECUTABLE = (GoalStatus.ACCEPTED, GoalStatus.CANCELING)
"""Where a goal may be that is executed for the first time."""


class ServerGoal(Generic[RequestT, ResultT]):
    """One goal of a server. Only the reactor changes it; a user's handle may outlive its place there."""

    __slots__ = (
        'client',
        'ended',
        'execution',
        'goal_id',
        'handle',
        'request',
        'result',
        'stamp_ns',
        'started',
        'status',
        'waiting',
    )

    def __init__(self, goal_id: GoalId, client: bytes = b'', request: RequestT | None = None) -> None:
        self.goal_id = goal_id
        self.client = client
        """The client that has sent it, as on_client_lost knows it."""
        self.request = request
        """The request for it, until that is answered."""
        self.status = GoalStatus.UNKNOWN
        """UNKNOWN until it is accepted, and once it is discarded."""
        self.stamp_ns = 0
        """When it was accepted (ROS time)."""
        self.started = False
        """True once it has been handed to the execute callback."""
        self.ended = False
        """True once status and result are both final."""
        self.result: ResultT | None = None
        self.waiting: list[RequestT] = []
        """The requests for its result that are to be answered."""
        self.handle: Any = None
        """The caller's handle of the goal, for its callbacks; None once the goal has ended."""
        self.execution: Any = None
        """The caller's execution, until the goal's turn has come; None before and after that."""


@record
class ServedGoals:
    """How much a server holds at the moment, and how many goals it has had."""

    deciding: int
    active: int
    running: int
    """Handed to the execute callback, which has not returned yet."""
    waiting: int
    """Accepted, their turn to come."""
    retained: int
    cancellations: int
    waiting_for_results: int
    accepted: int
    refused: int
    succeeded: int
    canceled: int
    aborted: int


class GoalServer(Generic[RequestT, ResultT]):
    """Every goal of one action server, from its request until its result is discarded.

    `result_timeout_ns` after its end a goal is discarded: at once for 0 (clients that wait already get the
    result), never for a negative one.
    """

    def __init__(
        self,
        result_timeout_ns: int = RESULT_TIMEOUT_NS,
        policy: GoalPolicy = UNLIMITED,
        on_client_lost: OnClientLost = 'keep',
    ) -> None:
        """Raises ValueError for an unknown `on_client_lost`, TypeError for anything but a policy."""
        if not isinstance(policy, GoalPolicy):
            raise TypeError(f'policy is what goalwire.single(), preempt(), … return, not {policy!r}')
        if on_client_lost not in ON_CLIENT_LOST:
            raise ValueError(
                f'on_client_lost is {" or ".join(map(repr, ON_CLIENT_LOST))}, not {on_client_lost!r}'
            )
        self._result_timeout_ns = result_timeout_ns
        self._lost = on_client_lost
        self._places: Places[ServerGoal[RequestT, ResultT]] = Places(policy)
        self._reached = [0] * len(GoalStatus)
        """How many goals have reached each status; UNKNOWN counts those refused."""
        self.deciding: dict[GoalId, ServerGoal[RequestT, ResultT]] = {}
        """Goals about which the user has been asked."""
        self.goals: dict[GoalId, ServerGoal[RequestT, ResultT]] = {}
        """Those that were accepted, in this order, until their results expire."""
        self._cancellations: dict[int, Cancellation[RequestT]] = {}
        self._next_cancellation = 0
        self._expiring: list[tuple[int, GoalId]] = []
        """A heap: simulated time may go back, so the oldest result need not be the first to go."""
        self._statuses = StatusArray()
        self.take_status = self._statuses.take
        """Return the serialised status array to publish; None if nothing has changed since the last."""
        self._closed = False

    # ---- what is known ----

    @property
    def policy(self) -> GoalPolicy:
        """How many goals run at a time."""
        return self._places.policy

    @property
    def watches_clients(self) -> bool:
        """True if on_client_lost makes a difference."""
        return self._lost != 'keep'

    def status(self, goal_id: GoalId) -> GoalStatus:
        """Return where a goal stands; UNKNOWN if it is not retained."""
        goal = self.goals.get(goal_id)
        return GoalStatus.UNKNOWN if goal is None else goal.status

    def statistics(self) -> ServedGoals:
        """Count what is held."""
        goals = self.goals.values()
        reached = self._reached
        return ServedGoals(
            deciding=len(self.deciding),
            active=sum(goal.status.is_active for goal in goals),
            running=self._places.running,
            waiting=len(self._places.waiting),
            retained=len(goals),
            cancellations=len(self._cancellations),
            waiting_for_results=sum(len(goal.waiting) for goal in goals),
            accepted=reached[GoalStatus.ACCEPTED],
            refused=reached[GoalStatus.UNKNOWN],
            succeeded=reached[GoalStatus.SUCCEEDED],
            canceled=reached[GoalStatus.CANCELED],
            aborted=reached[GoalStatus.ABORTED],
        )

    # ---- goals ----

    def on_goal_request(
        self, goal_id: GoalId, request: RequestT, now: int, client: bytes = b''
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client sends a goal: [AskGoal], or [ReplyGoal] if its id, or every place, is taken.

        `client` is what on_client_lost will know it by.
        """
        if self._expiring:
            self._expire(now)
        id_is_taken = goal_id in self.deciding or goal_id in self.goals
        if self._closed or id_is_taken or self._places.are_taken:
            return self._refuse(request)
        self.deciding[goal_id] = ServerGoal(goal_id, client, request)
        return [AskGoal(goal_id)]

    def on_goal_decision(
        self, goal_id: GoalId, accepted: bool, stamp_ns: int, handle: object = None
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """The user has decided (a failed callback has refused): [ReplyGoal, Accepted], or [ReplyGoal].

        The goal is refused as well if others have taken the last place meanwhile. `handle` goes into its
        record.
        """
        goal = self.deciding.pop(goal_id, None)
        if goal is None:
            return []
        request, goal.request = goal.request, None
        assert request is not None
        if not accepted or self._places.are_taken:
            return self._refuse(request)
        self._statuses.add(goal_id, stamp_ns, GoalStatus.ACCEPTED)
        goal.status, goal.stamp_ns, goal.handle = GoalStatus.ACCEPTED, stamp_ns, handle
        self._places.unfinished[goal_id] = goal
        self.goals[goal_id] = goal
        self._reached[GoalStatus.ACCEPTED] += 1
        return [ReplyGoal(request, accepted=True, stamp_ns=stamp_ns), Accepted(goal_id)]

    def _refuse(self, request: RequestT) -> list[ServerEffect[RequestT, ResultT]]:
        self._reached[GoalStatus.UNKNOWN] += 1
        return [ReplyGoal(request, accepted=False, stamp_ns=0)]

    def on_execute(
        self, goal_id: GoalId, now: int, execution: object = None
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """The user wants the goal executed: [PublishStatus, Execute]; [PublishStatus] if it has to wait.

        `execution` comes back with Execute. Under preempt() the goals before it are cancelled:
        [PublishStatus, StoppedByServer]. A goal whose cancellation was accepted before stays CANCELING:
        [Execute]; if it had to wait it ends. One that waits already goes on waiting: []. Raises
        InvalidTransition for one that was executed before or has ended.
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

    def _start(self, goal: ServerGoal[RequestT, ResultT]) -> list[ServerEffect[RequestT, ResultT]]:
        goal.started = True
        self._places.running += 1
        execute = Execute(goal.goal_id, goal.execution)
        goal.execution = None
        if goal.status is GoalStatus.CANCELING:
            return [execute]
        self._move(goal, GoalEvent.EXECUTE)
        return [PublishStatus(), execute]

    def _preempt(
        self, newest: ServerGoal[RequestT, ResultT], now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """Cancel every other goal that runs, or waits for its turn."""
        effects: list[ServerEffect[RequestT, ResultT]] = []
        for goal in list(self._places.unfinished.values()):
            if goal is not newest and (goal.started or goal.goal_id in self._places.waiting):
                effects += self._cancel(goal, now)
        return effects

    def on_event(self, goal_id: GoalId, event: GoalEvent, now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """The user ends the goal by SUCCEED, ABORT or CANCELED: [PublishStatus].

        The result follows with `on_result`. A goal that was never executed has none to wait for and gets the
        default: [PublishStatus, ReplyResult…, WakeAt]. Raises InvalidTransition.
        """
        goal = self.goals.get(goal_id)
        if goal is None:
            return []
        self._move(goal, event)
        return [PublishStatus(), *([] if goal.started else self._end(goal, None, now))]

    def on_result(
        self, goal_id: GoalId, result: ResultT | None, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """Execution is over, with its result (None: the default): [ReplyResult…, WakeAt].

        Where the user set no terminal state the goal is aborted: [AssumedAborted, PublishStatus,
        ReplyResult…, WakeAt].
        """
        goal = self.goals.get(goal_id)
        if goal is None or goal.ended:
            return []
        effects: list[ServerEffect[RequestT, ResultT]] = []
        if not goal.status.is_terminal:
            self._move(goal, GoalEvent.ABORT)
            effects = [AssumedAborted(goal_id), PublishStatus()]
        return effects + self._end(goal, result, now)

    # ---- cancelling ----

    def on_cancel_request(
        self, goal_id: GoalId, stamp_ns: int, request: RequestT, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client asks to cancel: [AskCancel…] in order of acceptance; [ReplyCancel] for nothing to ask."""
        if self._expiring:
            self._expire(now)
        code, chosen = choose(self.goals, goal_id, stamp_ns)
        if not chosen:
            return [ReplyCancel(request, code, ())]
        number = self._next_cancellation
        self._next_cancellation += 1
        is_for_one = stamp_ns == 0 and chosen == (goal_id,)
        self._cancellations[number] = Cancellation(request, chosen, is_for_one=is_for_one)
        return [AskCancel(number, id_) for id_ in chosen]

    def on_cancel_decision(
        self, cancellation: int, goal_id: GoalId, accepted: bool, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """The user has decided about one goal (a callback that failed has refused).

        The goal is CANCELING at once, or CANCELED if it waits for its turn: [PublishStatus, ReplyResult…,
        WakeAt]. With the last decision: [PublishStatus, ReplyCancel], or [ReplyCancel] if no goal is
        cancelled.
        """
        open_one = self._cancellations.get(cancellation)
        if open_one is None or goal_id not in open_one.undecided:
            return []
        open_one.undecided.remove(goal_id)
        effects: list[ServerEffect[RequestT, ResultT]] = []
        goal = self.goals.get(goal_id)
        if goal is None or not goal.status.is_cancelable:
            open_one.came_too_late = True
        elif accepted:
            open_one.canceling[goal_id] = goal.stamp_ns
            self._move(goal, GoalEvent.CANCEL_GOAL)
            if goal_id in self._places.waiting:
                effects = self._end_waiting(goal, now)
        return effects if open_one.undecided else effects + self._answer_cancellation(cancellation)

    def _answer_cancellation(self, number: int) -> list[ServerEffect[RequestT, ResultT]]:
        done = self._cancellations.pop(number)
        goals = tuple((id_, done.canceling[id_]) for id_ in done.goals if id_ in done.canceling)
        published: list[ServerEffect[RequestT, ResultT]] = [PublishStatus()] if goals else []
        return [*published, ReplyCancel(done.request, done.code, goals)]

    def _cancel(self, goal: ServerGoal[RequestT, ResultT], now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """Cancel a goal though no client has asked for that; nothing if it is being cancelled."""
        if not goal.status.is_cancelable:
            return []
        self._move(goal, GoalEvent.CANCEL_GOAL)
        if goal.goal_id in self._places.waiting:
            return self._end_waiting(goal, now)
        return [PublishStatus(), StoppedByServer(goal.goal_id)]

    def _end_waiting(
        self, goal: ServerGoal[RequestT, ResultT], now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """End a goal that is CANCELING before its turn has come."""
        self._move(goal, GoalEvent.CANCELED)
        return [PublishStatus(), *self._end(goal, None, now)]

    # ---- clients ----

    def on_client_lost(self, client: bytes, now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """A client has gone: its goals are kept, cancelled or aborted.

        Those that are still being decided are refused: [ReplyGoal…]. The others: [PublishStatus,
        StoppedByServer…], or their end if they do not run.
        """
        effects: list[ServerEffect[RequestT, ResultT]] = []
        if self._lost == 'keep':
            return effects
        for goal in list(self.deciding.values()):
            if goal.client == client:
                effects += self.on_goal_decision(goal.goal_id, accepted=False, stamp_ns=0)
        end = self._cancel if self._lost == 'cancel' else self._abort
        for goal in list(self._places.unfinished.values()):
            if goal.client == client:
                effects += end(goal, now)
        return effects

    def _abort(self, goal: ServerGoal[RequestT, ResultT], now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """Abort a goal, whatever it is doing; nothing if it has ended."""
        if goal.status.is_terminal:
            return []
        self._move_to_abortion(goal)
        if goal.started:
            return [PublishStatus(), StoppedByServer(goal.goal_id)]
        return [PublishStatus(), *self._end(goal, None, now)]

    # ---- results ----

    def on_result_request(
        self, goal_id: GoalId, request: RequestT, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """A client asks for a result: [ReplyResult], or nothing until the goal has ended."""
        if self._expiring:
            self._expire(now)
        goal = self.goals.get(goal_id)
        if goal is None:
            return [ReplyResult(request, GoalStatus.UNKNOWN, None)]
        if goal.ended:
            return [ReplyResult(request, goal.status, goal.result)]
        goal.waiting.append(request)
        return []

    def on_time(self, now: int) -> list[ServerEffect[RequestT, ResultT]]:
        """The time of a WakeAt has come: discard what has expired; [WakeAt] if more is to come."""
        self._expire(now)
        return [WakeAt(self._expiring[0][0])] if self._expiring else []

    # ---- the end ----

    def on_close(self) -> list[ServerEffect[RequestT, ResultT]]:
        """The server goes away: every open request is answered, every active goal aborted.

        [ReplyGoal…, (PublishStatus,) ReplyCancel…, PublishStatus, ReplyResult…]; afterwards goals are
        refused.
        """
        self._closed = True
        self._places.clear()
        effects: list[ServerEffect[RequestT, ResultT]] = []
        for goal_id in list(self.deciding):
            effects += self.on_goal_decision(goal_id, accepted=False, stamp_ns=0)
        for number in list(self._cancellations):
            effects += self._answer_cancellation(number)
        for goal in self.goals.values():
            if not goal.status.is_terminal:
                self._move_to_abortion(goal)
        effects.append(PublishStatus())
        for goal in list(self.goals.values()):
            effects += [ReplyResult(request, goal.status, goal.result) for request in goal.waiting]
            self._discard(goal)
        self._expiring.clear()
        return effects

    # ---- the one place where goals change ----

    def _move(self, goal: ServerGoal[RequestT, ResultT], event: GoalEvent) -> None:
        goal.status = status = after(goal.status, event)
        self._reached[status] += 1
        self._statuses.update(goal.goal_id, status)

    def _move_to_abortion(self, goal: ServerGoal[RequestT, ResultT]) -> None:
        if goal.status is GoalStatus.ACCEPTED:  # the table knows no shorter way
            self._move(goal, GoalEvent.EXECUTE)
        self._move(goal, GoalEvent.ABORT)

    def _end(
        self, goal: ServerGoal[RequestT, ResultT], result: ResultT | None, now: int
    ) -> list[ServerEffect[RequestT, ResultT]]:
        """Status and result are final: answer the waiting requests, keep the result, start waiting goals."""
        places = self._places
        places.unfinished.pop(goal.goal_id, None)
        if goal.started:
            places.running -= 1
        else:
            places.waiting.pop(goal.goal_id, None)
        goal.ended, goal.result, goal.handle, goal.execution = True, result, None, None
        effects: list[ServerEffect[RequestT, ResultT]] = [
            ReplyResult(request, goal.status, result) for request in goal.waiting
        ]
        goal.waiting.clear()
        if self._result_timeout_ns == 0:
            self._discard(goal)
        elif self._result_timeout_ns > 0:
            expiry = (now + self._result_timeout_ns, goal.goal_id)
            heappush(self._expiring, expiry)
            if self._expiring[0] is expiry:
                effects.append(WakeAt(expiry[0]))
        while places.waiting and (following := places.next()) is not None:
            effects += self._start(following)
        return effects

    def _expire(self, now: int) -> None:
        while self._expiring and self._expiring[0][0] <= now:
            self._discard(self.goals[heappop(self._expiring)[1]])

    def _discard(self, goal: ServerGoal[RequestT, ResultT]) -> None:
        """Remove a goal: a handle of it that is left then has the status UNKNOWN."""
        del self.goals[goal.goal_id]
        self._statuses.remove(goal.goal_id)
        goal.status, goal.handle, goal.execution = GoalStatus.UNKNOWN, None, None
