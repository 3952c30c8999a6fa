"""The goals that an action server holds, and the one place where their states change.

The reactor (server.py) decides what happens to a goal. This module keeps a record of each goal, the
serialised array of all statuses, the counters, and the results until they expire.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any, Generic

from goalwire.records import record
from goalwire.rules.goals.effects import RequestT, ResultT
from goalwire.rules.goals.policy import GoalPolicy, Places
from goalwire.rules.goals.states import GoalEvent, GoalStatus, after
from goalwire.rules.goals.status_array import StatusArray

if TYPE_CHECKING:
    from goalwire.rules.goals.ids import GoalId

RESULT_TIMEOUT_NS = 10_000_000_000
"""The time for which results are kept, in ns (rcl_action's default)."""


class ServerGoal(Generic[RequestT, ResultT]):
    """The server's record of one goal. Only the reactor changes it. Goal handles may outlive its removal."""

    __slots__ = (
        'client',
        'ended',
        'execution',
        'followers',
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
        """The send_goal request, until it is answered."""
        self.status = GoalStatus.UNKNOWN
        """UNKNOWN until it is accepted, and once it is discarded."""
        self.stamp_ns = 0
        """The time of its acceptance (ROS time)."""
        self.started = False
        """True once it has been handed to the execute callback."""
        self.ended = False
        """True once status and result are both final."""
        self.result: ResultT | None = None
        self.waiting: list[RequestT] = []
        """The requests for its result that are not answered yet."""
        self.followers: set[bytes] = set()
        """The living clients that have asked for its result, if goals of lost clients have a grace period."""
        self.handle: Any = None
        """The caller's goal handle, which its callbacks get; None once the goal has ended."""
        self.execution: Any = None
        """The caller's execution, while the goal waits for its turn; else None."""


@record
class ServedGoals:
    """How many goals a server has now, and has had so far."""

    deciding: int
    active: int
    running: int
    """Goals whose execute callback has not returned yet."""
    waiting: int
    """Accepted goals that wait for their turn."""
    retained: int
    cancellations: int
    waiting_for_results: int
    accepted: int
    refused: int
    succeeded: int
    canceled: int
    aborted: int


class GoalBook(Generic[RequestT, ResultT]):
    """All goals of one action server, each from its request until its result is discarded.

    A goal is discarded `result_timeout_ns` after its end. With a timeout of 0 it is discarded as soon as the
    waiting clients have got the result. With a negative timeout it is never discarded.
    """

    def __init__(self, result_timeout_ns: int, policy: GoalPolicy) -> None:
        self._result_timeout_ns = result_timeout_ns
        self.places: Places[ServerGoal[RequestT, ResultT]] = Places(policy)
        """The accepted goals that run, and those that wait for their turn."""
        self.deciding: dict[GoalId, ServerGoal[RequestT, ResultT]] = {}
        """Goals about which the user has not decided yet."""
        self.goals: dict[GoalId, ServerGoal[RequestT, ResultT]] = {}
        """The accepted goals in the order of acceptance, until their results expire."""
        self._reached = [0] * len(GoalStatus)
        """The number of goals that have reached each status; UNKNOWN counts the refused goals."""
        self._statuses = StatusArray()
        self.take_status = self._statuses.take
        """Return the serialised status array to publish; None if nothing has changed since the last."""
        self.expiring: list[tuple[int, GoalId]] = []
        """The times at which the results expire. It is a heap, since simulated time may go back: then a newer
        result expires before an older one."""

    def status(self, goal_id: GoalId) -> GoalStatus:
        """Return a goal's status; UNKNOWN if the goal is not retained."""
        goal = self.goals.get(goal_id)
        return GoalStatus.UNKNOWN if goal is None else goal.status

    def refuse(self) -> None:
        """Count a refused goal."""
        self._reached[GoalStatus.UNKNOWN] += 1

    def accept(self, goal: ServerGoal[RequestT, ResultT], stamp_ns: int, handle: object) -> None:
        """Record that a goal was accepted, with its time (ROS time) and the caller's goal handle."""
        self._statuses.add(goal.goal_id, stamp_ns, GoalStatus.ACCEPTED)
        goal.status, goal.stamp_ns, goal.handle = GoalStatus.ACCEPTED, stamp_ns, handle
        self.places.unfinished[goal.goal_id] = goal
        self.goals[goal.goal_id] = goal
        self._reached[GoalStatus.ACCEPTED] += 1

    def move(self, goal: ServerGoal[RequestT, ResultT], event: GoalEvent) -> None:
        """Change a goal's state by an event. Raises InvalidTransition if the table does not allow it."""
        goal.status = status = after(goal.status, event)
        self._reached[status] += 1
        self._statuses.update(goal.goal_id, status)

    def abort(self, goal: ServerGoal[RequestT, ResultT]) -> None:
        """Move a goal that has not ended to ABORTED."""
        if goal.status is GoalStatus.ACCEPTED:  # the table leads from ACCEPTED to ABORTED only by EXECUTING
            self.move(goal, GoalEvent.EXECUTE)
        self.move(goal, GoalEvent.ABORT)

    def finish(self, goal: ServerGoal[RequestT, ResultT], result: ResultT | None, now: int) -> int | None:
        """Keep a goal's final result, and free the goal's place.

        Returns the time at which to call `expire` if it is earlier than the time of every earlier result;
        else None.
        """
        places = self.places
        places.unfinished.pop(goal.goal_id, None)
        if goal.started:
            places.running -= 1
        else:
            places.waiting.pop(goal.goal_id, None)
        goal.ended, goal.result, goal.handle, goal.execution = True, result, None, None
        if self._result_timeout_ns == 0:
            self.discard(goal)
        elif self._result_timeout_ns > 0:
            expiry = (now + self._result_timeout_ns, goal.goal_id)
            heappush(self.expiring, expiry)
            if self.expiring[0] is expiry:
                return expiry[0]
        return None

    def expire(self, now: int) -> None:
        """Discard the goals whose results were kept for long enough."""
        while self.expiring and self.expiring[0][0] <= now:
            self.discard(self.goals[heappop(self.expiring)[1]])

    def unfollow(self, client: bytes) -> None:
        """Note that a client has gone: it is a follower of no goal any more."""
        for goal in self.places.unfinished.values():
            goal.followers.discard(client)

    def orphans(self, client: bytes) -> list[ServerGoal[RequestT, ResultT]]:
        """Return the goals of a lost client that no other client follows.

        Its other goals now belong to one of their followers.
        """
        found = []
        for goal in self.places.unfinished.values():
            if goal.client == client and goal.followers:
                goal.client = next(iter(goal.followers))
            elif goal.client == client:
                found.append(goal)
        return found

    def discard(self, goal: ServerGoal[RequestT, ResultT]) -> None:
        """Remove a goal. A goal handle that still refers to it has the status UNKNOWN from then on."""
        del self.goals[goal.goal_id]
        self._statuses.remove(goal.goal_id)
        goal.status, goal.handle, goal.execution = GoalStatus.UNKNOWN, None, None

    def statistics(self, cancellations: int) -> ServedGoals:
        """Return the statistics of the goals. The caller passes the number of open cancel requests."""
        goals = self.goals.values()
        reached = self._reached
        return ServedGoals(
            deciding=len(self.deciding),
            active=sum(goal.status.is_active for goal in goals),
            running=self.places.running,
            waiting=len(self.places.waiting),
            retained=len(goals),
            cancellations=cancellations,
            waiting_for_results=sum(len(goal.waiting) for goal in goals),
            accepted=reached[GoalStatus.ACCEPTED],
            refused=reached[GoalStatus.UNKNOWN],
            succeeded=reached[GoalStatus.SUCCEEDED],
            canceled=reached[GoalStatus.CANCELED],
            aborted=reached[GoalStatus.ABORTED],
        )
