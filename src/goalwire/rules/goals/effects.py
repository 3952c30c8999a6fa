"""Effects: the actions that the reactors ask of their caller. The caller performs them one by one, in
order.

`request` is the object that the caller passed in with the request which the effect answers. Ids are 16
bytes. Times are in nanoseconds.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from goalwire.records import record

if TYPE_CHECKING:
    from goalwire.rules.goals.cancel import CancelCode
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.table import GoalStatus

RequestT = TypeVar('RequestT')
ResultT = TypeVar('ResultT')
WaiterT = TypeVar('WaiterT')

# ---- the server's ----


@record
class AskGoal:
    """Ask the user whether the goal is accepted; answer with `on_goal_decision`."""

    goal_id: GoalId


@record
class ReplyGoal(Generic[RequestT]):
    """Answer a send_goal request. `stamp_ns` is 0 for a goal that is not accepted."""

    request: RequestT
    accepted: bool
    stamp_ns: int


@record
class Accepted:
    """Hand the goal to the user's handle_accepted callback, which may execute it at once or later."""

    goal_id: GoalId


@record
class Execute:
    """Start the user's execute callback, and pass its return value to `on_result`.

    Under a policy this may be an effect of the end of another goal. `execution` is the object that the caller
    passed to `on_execute`.
    """

    goal_id: GoalId
    execution: Any = None


@record
class StoppedByServer:
    """Tell the program that the server itself has made the goal CANCELING or ABORTED, without a request."""

    goal_id: GoalId


@record
class AskCancel:
    """Ask the user whether the goal is to be cancelled; answer with `on_cancel_decision`."""

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
    """Answer a get_result request; a `result` of None stands for the type's default."""

    request: RequestT
    status: GoalStatus
    result: ResultT | None


@record
class KeepResult(Generic[RequestT, ResultT]):
    """Write the end of a goal into the server's journal; then answer the requests for its result.

    Only servers with a journal have this effect, in place of ReplyResult.
    """

    goal_id: GoalId
    status: GoalStatus
    result: ResultT | None
    requests: tuple[RequestT, ...]


@record
class FindResult(Generic[RequestT]):
    """Answer a get_result request from the server's journal: the goal has ended, or is unknown here."""

    request: RequestT
    goal_id: GoalId


@record
class PublishStatus:
    """Publish the result of `take_status()`, unless it is None: then an earlier array told every change."""


@record
class AssumedAborted:
    """Warn that the execute callback set no terminal state."""

    goal_id: GoalId


@record
class WakeAt:
    """Call `on_time` at `time_ns`; replaces an earlier WakeAt."""

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

# ---- the client's ----


@record
class GoalAccepted:
    """Tell the sender that its goal was accepted. `status` is the latest status from the status topic."""

    goal_id: GoalId
    status: GoalStatus


@record
class GoalRejected:
    """Tell the sender that its goal was refused."""

    goal_id: GoalId


@record
class UnexpectedReply:
    """Warn of an answer to a goal that awaits none. There may be more than one server of the action."""

    goal_id: GoalId


@record
class StatusChanged:
    """A goal has another status."""

    goal_id: GoalId
    status: GoalStatus


@record
class RequestResult:
    """Send a get_result request; hand its outcome to `on_result` or `on_result_failed`."""

    goal_id: GoalId


@record
class DeliverResult(Generic[WaiterT, ResultT]):
    """Complete a waiter with the result."""

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
