"""Effects: the actions that the reactors ask of their caller. The caller performs them one by one, in
order.

An effect that answers a request names it by `request`, the object that the caller had passed in with it. Goal
ids are 16 bytes. Times are in nanoseconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.rules.goals.cancel_requests import CancelCode
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.states import GoalStatus

RequestT = TypeVar('RequestT')
ResultT = TypeVar('ResultT')
WaiterT = TypeVar('WaiterT')

# ---- effects of the server ----


@record
class AskGoal:
    """Ask the user whether to accept a goal, and pass the decision to `on_goal_decision`."""

    goal_id: GoalId


@record
class ReplyGoal(Generic[RequestT]):
    """Answer a send_goal request. `stamp_ns` is 0 if the goal is not accepted."""

    request: RequestT
    accepted: bool
    stamp_ns: int


@record
class Accepted:
    """Hand an accepted goal to the user's handle_accepted callback, which may execute it at once or later."""

    goal_id: GoalId


@record
class Execute:
    """Start the user's execute callback, and pass its return value to `on_result`.

    Under a policy that lets goals wait, the end of another goal may have this effect. `execution` is the
    object that the caller passed to `on_execute`.
    """

    goal_id: GoalId
    execution: Any = None


@record
class StoppedByServer:
    """Tell the program that the server has made a goal CANCELING or ABORTED without a client's request."""

    goal_id: GoalId


@record
class AskCancel:
    """Ask the user whether to cancel a goal, and pass the decision to `on_cancel_decision`."""

    cancellation: int
    goal_id: GoalId


@record
class ReplyCancel(Generic[RequestT]):
    """Answer a cancel_goal request. `goals`: ids and acceptance stamps of the goals that are
    CANCELING now.
    """

    request: RequestT
    code: CancelCode
    goals: tuple[tuple[GoalId, int], ...]


@record
class ReplyResult(Generic[RequestT, ResultT]):
    """Answer a get_result request. If `result` is None, the answer has the result type's default."""

    request: RequestT
    status: GoalStatus
    result: ResultT | None


@record
class KeepResult(Generic[RequestT, ResultT]):
    """Write a goal's final status and result into the server's journal, then answer `requests` for it.

    Only servers with a journal have this effect, in place of ReplyResult.
    """

    goal_id: GoalId
    status: GoalStatus
    result: ResultT | None
    requests: tuple[RequestT, ...]


@record
class FindResult(Generic[RequestT]):
    """Answer a get_result request from the journal: the goal has ended, or this process does not know it."""

    request: RequestT
    goal_id: GoalId


@record
class PublishStatus:
    """Publish the status array that `take_status()` returns.

    If it returns None, an earlier array had every change.
    """


@record
class AssumedAborted:
    """Warn that the goal was aborted because its execute callback has set no terminal state."""

    goal_id: GoalId


@record
class WakeAt:
    """Call `on_time` at `time_ns`. This replaces an earlier WakeAt."""

    time_ns: int


ServerEffect: TypeAlias = (
    AskGoal
    | ReplyGoal[RequestT]
    | Accepted
    | Execute
    | StoppedByServer
    | AskCancel
    | ReplyCancel[RequestT]
    | ReplyResult[RequestT, ResultT]
    | KeepResult[RequestT, ResultT]
    | FindResult[RequestT]
    | PublishStatus
    | AssumedAborted
    | WakeAt
)
ServerEffects: TypeAlias = list[ServerEffect[RequestT, ResultT]]

# ---- effects of the client ----


@record
class GoalAccepted:
    """Tell the goal's sender that it was accepted.

    `status` is the goal's latest status from the status topic.
    """

    goal_id: GoalId
    status: GoalStatus


@record
class GoalRejected:
    """Tell the goal's sender that the goal was refused."""

    goal_id: GoalId


@record
class UnexpectedReply:
    """Warn of an answer to a goal that awaits no answer. The action may have more than one server."""

    goal_id: GoalId


@record
class StatusChanged:
    """Note that a goal has another status."""

    goal_id: GoalId
    status: GoalStatus


@record
class RequestResult:
    """Send a get_result request; hand its outcome to `on_result` or `on_result_failed`."""

    goal_id: GoalId


@record
class DeliverResult(Generic[WaiterT, ResultT]):
    """Complete a waiter with the goal's result."""

    waiter: WaiterT
    status: GoalStatus
    result: ResultT


@record
class FailResult(Generic[WaiterT]):
    """Complete a waiter with the error that explains the missing result."""

    waiter: WaiterT
    error: Exception


ClientEffect: TypeAlias = (
    GoalAccepted
    | GoalRejected
    | UnexpectedReply
    | StatusChanged
    | RequestResult
    | DeliverResult[WaiterT, ResultT]
    | FailResult[WaiterT]
)
