"""A goal on the server's side: the handle that callbacks get, their answers, and one run of execute."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from enum import Enum
from types import CoroutineType
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol

from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT, goal_id_bytes, uuid_message
from goalwire.entities.coroutines import Enclosing
from goalwire.errors import ShutDownError, peer_text
from goalwire.execution.ready_queue import CallbackSource
from goalwire.rules.goals.goal_book import ServerGoal
from goalwire.rules.goals.states import GoalEvent, GoalStatus

if TYPE_CHECKING:
    from action_msgs.msg import GoalInfo
    from unique_identifier_msgs.msg import UUID

    from goalwire.entities.node import NodeCore
    from goalwire.execution.time.steady_clock import SteadyClock
    from goalwire.execution.time.timer_heap import TimerEntry
    from goalwire.logging import RcutilsLogger
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.latencies import Latencies


class GoalResponse(Enum):
    """The answer of a goal callback."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """The answer of a cancel callback."""

    REJECT = 1
    ACCEPT = 2


class ActionCallbacks:
    """The user's callbacks; the first four may be `async def`."""

    __slots__ = ('accepted', 'cancel', 'execute', 'failed', 'goal', 'stopped_by_server')

    def __init__(
        self,
        execute: Callable[[ServerGoalHandle], Any] | None,
        goal: Callable[[Any], Any],
        accepted: Callable[[ServerGoalHandle], Any],
        cancel: Callable[[ServerGoalHandle], Any],
        failed: Callable[[ServerGoalHandle, Exception], object] | None = None,
        stopped_by_server: Callable[[ServerGoalHandle], object] | None = None,
    ) -> None:
        self.execute = execute
        """The execute callback; None: the program executes its goals itself (ServerGoalHandle.executing).
        """
        self.goal = goal
        self.accepted = accepted
        self.cancel = cancel
        self.failed = failed
        """Called with the error that execute raised; may return a result to send along."""
        self.stopped_by_server = stopped_by_server
        """Called with a goal that the server's own policy has cancelled or aborted."""


class Failure(NamedTuple):
    """The outcome of an execution that gave no usable result."""

    result: object = None
    """The result that is sent; None: one of default values."""
    reason: str = ''
    """The text that goalwire's clients get."""


class GoalServing(Protocol):
    """An action server as its goals see it (ActionServerCore)."""

    node: NodeCore
    logger: RcutilsLogger
    destroyed: bool
    steady_clock: SteadyClock
    durations: Latencies

    def goal(self, goal_id: GoalId) -> ServerGoal[Any, Any]:
        """Return the record of a goal; if there is none, a new record with the status UNKNOWN."""

    def start_execution(
        self, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any] | None
    ) -> None:
        """Have the executor execute a goal, in its turn."""

    def begin_execution(self, handle: ServerGoalHandle) -> None:
        """Note that the program executes a goal itself."""

    def publish_feedback(self, handle: ServerGoalHandle, feedback: Any) -> None:
        """Send a goal's feedback."""

    def end(self, handle: ServerGoalHandle, event: GoalEvent) -> None:
        """End a goal."""

    def finished(self, handle: ServerGoalHandle, outcome: object) -> None:
        """Take the outcome of the goal's execution: a result, or a Failure."""

    def failure(self, handle: ServerGoalHandle, error: Exception) -> Failure:
        """Call the program's on_failure with the error that execute raised; return the outcome for the
        client.
        """


class ServerGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    """The goal handle that execute, cancel and handle_accepted callbacks get. It may outlive its goal."""

    __slots__ = (
        '__dict__',
        '__weakref__',
        '_goal',
        '_server',
        '_uuid',
        'cancel_alarm',
        'executed_by',
        'goal_id_bytes',
        'looked_at_cancel',
        'request',
    )

    def __init__(
        self,
        action_server: GoalServing,
        goal_info: ServerGoal[Any, Any] | GoalInfo,
        goal_request: GoalT,
    ) -> None:
        """`goal_info` is the goal's record in the server's reactor, or its id and stamp as rclpy has them."""
        self._server = action_server
        self._uuid: UUID | None = None
        self.executed_by: Callable[..., object] | None = None
        """The execute callback that runs this goal."""
        self.looked_at_cancel = False
        """Whether the program has asked `is_cancel_requested`."""
        self.cancel_alarm: TimerEntry | None = None
        """Set when a cancellation is accepted. It warns if the program does not look at that for seconds.
        """
        self._goal = (
            goal_info
            if isinstance(goal_info, ServerGoal)
            else action_server.goal(goal_id_bytes(goal_info.goal_id))
        )
        self.goal_id_bytes = self._goal.goal_id
        self.request = goal_request
        """The goal message that the client sent."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and other.goal_id_bytes == self.goal_id_bytes

    def __hash__(self) -> int:
        return hash(self.goal_id_bytes)

    @property
    def goal_id(self) -> UUID:
        """The goal's id."""
        if self._uuid is None:
            self._uuid = uuid_message(self.goal_id_bytes)
        return self._uuid

    @property
    def status(self) -> int:
        """The goal's action_msgs/msg/GoalStatus number; STATUS_UNKNOWN once its result is no longer kept."""
        return int(self._goal.status)

    @property
    def is_active(self) -> bool:
        """True until the goal has ended."""
        return self._goal.status.is_active

    @property
    def is_cancel_requested(self) -> bool:
        """True once a cancel request was accepted, until the goal has ended."""
        self.looked_at_cancel = True
        return self._goal.status is GoalStatus.CANCELING

    def execute(
        self,
        execute_callback: Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], object] | None = None,
    ) -> None:
        """Start the execute callback: the given one, or else the server's.

        Raises RCLError for a goal that was executed before or has ended.
        """
        self._server.start_execution(self, execute_callback)

    def executing(self) -> None:
        """Begin to execute the goal without a callback: the program itself ends the goal, at any time.

        Raises RCLError for a goal that was executed before or has ended.
        """
        self._server.begin_execution(self)

    def publish_feedback(self, feedback: FeedbackT) -> None:
        """Send feedback to the goal's client.

        Raises TypeError for an object of another type than the action's Feedback.
        """
        self._server.publish_feedback(self, feedback)

    def succeed(self, response: ResultT | None = None) -> None:
        """End the goal as SUCCEEDED; raises RCLError if its state does not allow that.

        `response` is its result. Without a `response` the return value of the execute callback is the result.
        """
        self._end(GoalEvent.SUCCEED, response)

    def abort(self, response: ResultT | None = None) -> None:
        """End the goal as ABORTED; response and errors are those of `succeed`."""
        self._end(GoalEvent.ABORT, response)

    def canceled(self, response: ResultT | None = None) -> None:
        """End the goal as CANCELED, once is_cancel_requested is true; response and errors are those of
        `succeed`.
        """
        self._end(GoalEvent.CANCELED, response)

    def _end(self, event: GoalEvent, response: ResultT | None) -> None:
        self._server.end(self, event)
        if response is not None:
            self._server.finished(self, response)

    def destroy(self) -> None:
        """Do nothing: a handle has nothing to close, but rclpy's programs may call this."""


class Execution(CallbackSource):
    """Runs an execute callback, in no callback group, as in rclpy."""

    __slots__ = ('_begun', '_callback', '_handle', '_server')

    def __init__(
        self, server: GoalServing, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any]
    ) -> None:
        super().__init__(server.node.work_queue, None)
        self._server = server
        self._handle = handle
        self._callback = handle.executed_by = callback
        self._begun = 0

    def run(self) -> object:
        server = self._server
        if server.destroyed:
            return None
        self._begun = server.steady_clock.now()
        try:
            result = self._callback(self._handle)
        except BaseException as error:
            self._fail(error)
            return None
        if isinstance(result, CoroutineType):
            return Enclosing(self._carry(result), [result])
        self._finish(result)
        return None

    async def _carry(self, coroutine: Coroutine[Any, Any, Any]) -> None:
        from asyncio import CancelledError

        try:
            result = await coroutine
        except CancelledError:  # the executor was shut down
            self._finish(Failure())
            raise
        except BaseException as error:
            self._fail(error)
        else:
            self._finish(result)

    def _finish(self, outcome: object) -> None:
        server = self._server
        server.durations.add(server.steady_clock.now() - self._begun)
        server.finished(self._handle, outcome)

    def _fail(self, error: BaseException) -> None:
        server = self._server
        if isinstance(error, ShutDownError) and not server.node.context.ok():
            server.logger.warning(f'A goal was stopped by the end of the context: {error}')
        else:
            from goalwire.places import raising_place
            from goalwire.tracebacks import traceback_text

            told = f'Error raised in execute callback: {peer_text(error)}'
            outcome = 'so the goal is aborted' if self._handle.is_active else 'the goal had ended before'
            remedy = f'correct {raising_place(error) or "the execute callback"}'
            server.logger.error(f'{told}; {outcome}: {remedy}\n{traceback_text(error)}')
        if isinstance(error, Exception):
            self._finish(server.failure(self._handle, error))
        else:
            self._finish(Failure())
            raise error
