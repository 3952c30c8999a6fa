"""A goal on the client's side: its handle, its queue of feedback, the future of its result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, Protocol

from goalwire.entities.actions.cancel_warnings import is_refusal, tell_refusal
from goalwire.entities.actions.types import FeedbackT, GoalT, ResultT, goal_id_bytes, uuid_message
from goalwire.execution.current_callback import current_groups, why_it_cannot_answer
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import STEADY
from goalwire.logging import get_logger
from goalwire.places import at, caller_place, dropping_place
from goalwire.rules.goals.client import ClientGoal

if TYPE_CHECKING:
    from collections.abc import Callable

    from action_msgs.srv import CancelGoal
    from builtin_interfaces.msg import Time
    from unique_identifier_msgs.msg import UUID

    from goalwire.entities.actions.types import ResultResponse
    from goalwire.entities.call_deadlines import CallContext
    from goalwire.entities.node import NodeCore
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal
    from goalwire.execution.time.steady_clock import SteadyClock
    from goalwire.rules.goals.client import FeedbackQueue
    from goalwire.rules.goals.ids import GoalId
    from goalwire.transport.contract import Sample

FEEDBACK_LIMIT = 1000
"""How many feedback messages may wait for one goal's callback; the oldest is dropped and counted."""


class AnswerWaiting(Protocol):
    """The blocking calls of an action client as its goals see them (BlockingCalls)."""

    def wait_for(self, ask: Callable[[], Future[Any]]) -> Any:
        """Ask the server, block until the answer is there and return it."""


class GoalSending(Protocol):
    """An action client as its goals see it (ActionClientCore)."""

    node: NodeCore

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""

    @property
    def blocking(self) -> AnswerWaiting:
        """The calls of this client that block a thread."""

    def goal(self, goal_id: GoalId) -> ClientGoal[Any]:
        """Return the record of a goal; if there is none, a new record with the status UNKNOWN."""

    def cancel_goal(self, goal_id: GoalId, *, asked_at: str = '') -> Future[Any]:
        """Ask for cancellation; see ActionClientCore."""

    def get_result(self, goal_id: GoalId) -> Future[Any]:
        """Ask for the result."""


class ResultWaiting(Protocol):
    """The results of an action client as their futures see them (GoalResults)."""

    def cancel(self, future: ResultFuture) -> None:
        """Stop waiting for this result."""


class ClientGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    """The handle that send_goal's future gives. It tells if the goal was accepted, gives its status and
    result, and cancels it.
    """

    def __init__(
        self, action_client: GoalSending, goal_id: ClientGoal[Any] | UUID, goal_response: Any
    ) -> None:
        """`goal_id` is the goal's record in the client's reactor, or the id with which the goal was sent.

        `goal_response` is the action's SendGoal response.
        """
        self._action_client = action_client
        self._goal = (
            goal_id if isinstance(goal_id, ClientGoal) else action_client.goal(goal_id_bytes(goal_id))
        )
        self._goal_response = goal_response

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and other._goal.goal_id == self._goal.goal_id

    __hash__ = None  # type: ignore[assignment]  # as in rclpy

    def __repr__(self) -> str:
        status = int(self._goal.status)
        return f'ClientGoalHandle <id={self.goal_id.uuid}, accepted={self.accepted}, status={status}>'

    @property
    def goal_id(self) -> UUID:
        """The goal's id."""
        return uuid_message(self._goal.goal_id)

    @property
    def stamp(self) -> Time:
        """When the server accepted the goal; zero if it did not."""
        stamp: Time = self._goal_response.stamp
        return stamp

    @property
    def accepted(self) -> bool:
        """True if the server accepted the goal."""
        return bool(self._goal_response.accepted)

    @property
    def status(self) -> int:
        """The goal's action_msgs/msg/GoalStatus number, as far as this client knows it."""
        return int(self._goal.status)

    @property
    def reason(self) -> str:
        """Why the goal was aborted; '' until the result comes, or if the server does not run on goalwire."""
        return self._goal.reason

    def cancel_goal(self) -> CancelGoal.Response | None:
        """Ask for cancellation and wait for the answer. Raises ShutDownError if the context ends,
        InvalidHandle if the client is destroyed.
        """
        answer: CancelGoal.Response | None = self._action_client.blocking.wait_for(self._ask_to_cancel)
        if answer is not None and is_refusal(answer) and (place := dropping_place()):
            tell_refusal(self._action_client.node, self._action_client.full_name, place)
        return answer

    def cancel_goal_async(self) -> Future[CancelGoal.Response]:
        """Ask for cancellation; the future gives the CancelGoal response: the goals to be cancelled."""
        return self._action_client.cancel_goal(self._goal.goal_id, asked_at=caller_place())

    def _ask_to_cancel(self) -> Future[CancelGoal.Response]:
        return self._action_client.cancel_goal(self._goal.goal_id)

    def get_result(self) -> ResultResponse[ResultT] | None:
        """Wait for the goal's end and return its status and result. Raises as cancel_goal does."""
        answer: ResultResponse[ResultT] | None = self._action_client.blocking.wait_for(self.get_result_async)
        return answer

    def get_result_async(self) -> Future[ResultResponse[ResultT]]:
        """Ask for the result; the future gives status and result (the action's GetResult response)."""
        if not self.accepted:
            self._tell_refused()
        return self._action_client.get_result(self._goal.goal_id)

    def _tell_refused(self) -> None:
        """Warn that a refused goal has no result: the server's answer will hold default values only."""
        node = self._action_client.node
        get_logger(node.logger_name).warning(
            'the server refused this goal, so it has no result: write '
            f"'if goal_handle.accepted:' before you ask for the result{at(caller_place())}"
        )


class ResultFuture(Future[Any]):
    """The future of a goal's result. All futures of one goal share one request; whoever reads a future
    decodes the result.

    If the goal has a feedback callback, the future is done after the last call of this callback.
    """

    __slots__ = ('_feedback', '_results', 'call_context', 'decode', 'goal_id')

    decode: Callable[[Any], Any]

    def __init__(
        self,
        results: ResultWaiting,
        work_queue: NodeWorkQueue,
        goal_id: GoalId,
        decode: Callable[[Any], Any],
        call_context: CallContext | None,
        feedback: FeedbackQueue | None,
    ) -> None:
        super().__init__(work_queue)
        self.goal_id = goal_id
        self.decode = decode
        self.call_context = call_context
        """The names and times for this future's errors; None: the future stays pending if nobody answers."""
        self._results = results
        self._feedback = feedback if isinstance(feedback, GoalFeedback) else None

    def cancel(self) -> None:
        """Stop waiting for the result. The goal goes on, as in ROS 2."""
        if self.pending():
            self._results.cancel(self)
        super().cancel()

    def add_waker(self, waker: Callable[[], None]) -> None:
        if self._feedback is not None and self.pending():
            self._feedback.hurry_if_stuck(blocks=False)
        super().add_waker(waker)

    def wait(
        self,
        deadline: int | None = None,
        *,
        clock: SteadyClock = STEADY,
        shutdown_signal: ShutdownSignal | None = None,
    ) -> bool:
        if self._feedback is not None and self.pending():
            self._feedback.hurry_if_stuck(blocks=True)
        return super().wait(deadline, clock=clock, shutdown_signal=shutdown_signal)


class GoalFeedback(EventQueue['Sample | None']):
    """Calls back with each feedback message of a goal. A None behind the last message is the goal's end.

    Feedback, acceptance and result arrive by different topics and services. Feedback that comes before the
    acceptance waits for `open`. `end` delays the result until the callbacks have run for all earlier
    feedback, but not if they cannot run while a thread waits for the result: see `hurry`.
    """

    __slots__ = ('_call', '_ends', '_is_ending', '_is_opening', '_owner', '_running', 'hurried')

    def __init__(
        self,
        work_queue: NodeWorkQueue,
        group: CallbackGroup,
        handle: Callable[[Sample], object],
        owner: object,
    ) -> None:
        super().__init__(work_queue, group, handle, depth=FEEDBACK_LIMIT)  # type: ignore[arg-type]
        self._call = handle
        self._posted = True  # so that no message posts this queue before `open`
        self._owner = owner
        self._is_opening = self._is_ending = False
        self._running: list[None] = []
        """One item for each callback under way, since several callbacks may run at the same time."""
        self._ends: list[Callable[[], object]] = []
        self.hurried = False

    @property
    def entity(self) -> object:
        return self._owner

    def open(self, *, in_a_turn: bool) -> None:
        """Let the feedback through: the goal is accepted.

        `in_a_turn`: the program does not know of the acceptance yet. Then one turn of the executor comes
        first, so that a done callback which the program adds before it spins runs before the feedback
        callbacks.
        """
        self._is_opening = in_a_turn
        if in_a_turn:
            self.work_queue.post(self)
        else:
            self._go_on()

    def end(self, then: Callable[[], object]) -> None:
        """Take no more feedback. Call `then` after the callbacks of all waiting messages; now, if no message
        waits.
        """
        self.closed = True
        self._ends.append(then)
        if self.hurried or not (self._posted or self._events or self._running):
            self._tell_end()
            return
        if len(self._events) == FEEDBACK_LIMIT:
            self.dropped += 1
        self._events.append(None)
        if not self._posted:
            self._go_on()

    def hurry(self) -> None:
        """Complete the result now: a caller blocks on it, and the feedback callbacks cannot run meanwhile."""
        self.hurried = True
        self._tell_end()

    def hurry_if_stuck(self, *, blocks: bool) -> None:
        """Hurry if the caller, who is about to wait for the result, would hold up the feedback callbacks.

        This is so if nobody spins, if the caller's callback holds their group, or if the caller `blocks`
        their thread.
        """
        queue = self.work_queue.queue
        driver = None if queue is None else queue.driver()
        if (
            driver is None
            or not driver.is_driven()
            or self.group in current_groups()
            or (blocks and why_it_cannot_answer(self.work_queue, self.group))
        ):
            self.hurry()

    def close(self) -> None:
        super().close()
        self._ends.clear()

    def handle(self, event: Sample | None) -> object:
        if event is not None:
            return self._call(event)
        self._tell_end()
        return None

    def run(self) -> object:
        """Run one callback, as `EventQueue.run` does. The code of that method is repeated here, which saves a
        call.
        """
        if self._is_opening:
            self._is_opening = False
            self._go_on()
            return None
        try:
            event = self._events.popleft()
        except IndexError:
            self._go_on()
            return None
        if self._alone:
            return self.handle(event) if event is None else self._call(event)
        return self._run_beside(event)

    def _run_beside(self, event: Sample | None) -> object:
        """Run the callback; others of this goal may run at the same time."""
        running = self._running
        if event is None:
            self._is_ending = True
            self._go_on()
        else:
            running.append(None)  # before `_go_on`, which lets another thread take the next event
            self._go_on()
            try:
                return self._call(event)
            finally:
                running.pop()
                if self._is_ending and not running:
                    self._tell_end()
        if not running:
            self._tell_end()
        return None

    def _tell_end(self) -> None:
        while self._ends:
            try:
                then = self._ends.pop(0)
            except IndexError:
                return  # another thread has taken the last function, and calls it
            then()
