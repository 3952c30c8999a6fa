"""A goal that was sent: its feedback, its result, cancelling it, and the check for a stuck server."""

from __future__ import annotations

import asyncio
import warnings
from collections.abc import AsyncIterator, Awaitable, Callable, Generator
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from goalwire.cdr import codec
from goalwire.entities.actions.client_goal_handle import FEEDBACK_LIMIT
from goalwire.entities.call_deadlines import CallContext
from goalwire.errors import (
    CallError,
    ClosedError,
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalFailed,
    GoalIdTaken,
    GoalRefused,
    RemoteError,
    ServerLostError,
    ServerStuckError,
    ShutDownError,
)
from goalwire.execution.asyncio.waiting import AsyncQueue, delay_s, settle
from goalwire.execution.future import Future
from goalwire.execution.time.steady_clock import timeout_ns
from goalwire.logging import get_logger
from goalwire.rules.goals.ids import new_goal_id
from goalwire.rules.goals.journal import SERVER_DIED
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.goals.wire import unwrap

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from goalwire.entities.actions.client import ActionClientCore
    from goalwire.entities.actions.client_goal_handle import ClientGoalHandle
    from goalwire.execution.shutdown_signal import ShutdownWatch
    from goalwire.execution.time.steady_clock import SteadyClock
    from goalwire.rules.goals.client import ClientGoal
    from goalwire.rules.goals.ids import GoalId
    from goalwire.transport.contract import Sample

ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')


class Limits(NamedTuple):
    """The time limits of a run, in s."""

    timeout: float | None
    """The limit of the whole run, from entering it to the result."""
    grace: float
    """The limit for the end of a goal that is cancelled because the block is left."""
    heartbeat: float | None
    """The longest time between two signs of life of the server."""


class Run(Generic[ResultT, FeedbackT]):
    """The run of one goal, made by ActionClient.send and attach. Enter it once by `async with`."""

    _not_entered = 'was not sent: async with client.send(…) as run:'

    def __init__(
        self,
        core: ActionClientCore,
        goal: object,
        limits: Limits,
        goal_id: GoalId | None = None,
        *,
        keep: bool = False,
    ) -> None:
        """`goal_id` is an id that the program has chosen. With `keep`, only `cancel` cancels the goal."""
        self._core = core
        self._goal = goal
        self._limits = limits
        self._has_own_id = goal_id is not None
        self._id = goal_id or new_goal_id()
        self._keep = keep
        self._record = core.goal(self._id)
        self._attempt: CallContext | None = None
        self._answer: Future[Any] | None = None
        self._stream: AsyncQueue[Sample] = AsyncQueue(FEEDBACK_LIMIT)
        self._alarm: asyncio.TimerHandle | None = None
        self._heartbeat: Heartbeat | None = None
        self._watch: ShutdownWatch | None = None

    # -- what it is ----------------------------------------------------------------------------------------

    @property
    def goal_id(self) -> bytes:
        """The goal's id, 16 bytes."""
        return self._id

    @property
    def status(self) -> GoalStatus:
        """The latest status of the goal that this client has received."""
        return self._record.status

    @property
    def feedback(self) -> AsyncIterator[FeedbackT]:
        """The feedback of the goal, for `async for`. The loop ends with the goal, and at the deadline.

        1000 messages wait at most; beyond that the oldest is dropped.
        """
        return _Feedback(self._core, self._stream)

    @property
    def result(self) -> Awaitable[ResultT]:
        """The result of a successful goal, to be awaited, also several times.

        Awaiting it raises GoalAborted, GoalCanceled, DeadlineError, ServerStuckError, ServerLostError or
        ServerFailedError; ShutDownError, InvalidHandle if the client is closed.
        """
        return _Result(self)

    async def cancel(self, *, timeout: float | None = None) -> bool:
        """Ask the server to cancel the goal; True if it accepts that. The result tells how the goal ended.

        Raises DeadlineError, ServerLostError, ServerFailedError, ShutDownError.
        """
        core = self._core
        limit = core.default_timeout if timeout is None else timeout
        return await self._cancel(CallContext(core.node.context, 'action', core.full_name, limit))

    def __del__(self) -> None:
        if self._attempt is None:
            warnings.warn(
                f"a goal for '{self._core.full_name}' {self._not_entered}",
                RuntimeWarning,
                stacklevel=2,
                source=self,
            )

    # -- its life ------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Wait for a server, send the goal, wait until it is accepted; an attached run sends nothing.

        Raises GoalRefused, NoServerError, DeadlineError, ServerLostError, ServerFailedError; ShutDownError,
        InvalidHandle; EncodeError for a field that cannot be encoded. Raises GoalIdTaken, and sends nothing,
        for an id that this client has used or that is in the server's latest status array.
        """
        if self._attempt is not None:
            raise ClosedError('this run was entered before: send the goal again')
        core = self._core
        context = core.node.context
        attempt = self._attempt = CallContext(context, 'action', core.full_name, self._limits.timeout)
        has_begun = False
        try:
            await self._begin(attempt)
            has_begun = True
        finally:
            if not has_begun:
                self._discard()  # the block was not entered, so __aexit__ will not run
        if attempt.deadline is not None:
            delay = delay_s(attempt.deadline - context.shutdown_signal.clock.now())
            self._alarm = asyncio.get_running_loop().call_later(delay, self._stream.close)
        if self._limits.heartbeat is not None:
            clock = context.shutdown_signal.clock
            self._heartbeat = Heartbeat(self._limits.heartbeat, self._record, clock, self._on_stuck)
        self._watch = context.shutdown_signal.watch(self._stream.close)
        return self

    async def _begin(self, attempt: CallContext) -> None:
        """Send the goal, and wait until it is accepted."""
        core = self._core
        if self._has_own_id:
            _refuse_known_id(core, self._id)
        until_accepted = None if self._limits.timeout is None else attempt
        sending = core.send_as(self._id, self._goal, self._stream, until_accepted, keep=self._keep)
        self._record = core.goal(self._id)
        try:
            if not await settle(sending, attempt.context.shutdown_signal):
                raise attempt.end_error()
            self._take(sending)
        except asyncio.CancelledError:
            if self._keep:
                sending.cancel()  # the caller's cancellation ends only this wait, not the goal
            else:
                await self._cancel_late(sending)
            raise

    def _take(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Read the server's answer to the goal; if it was accepted, ask for its result at once."""
        attempt = self._attempt
        try:
            handle = sending.result()
        except RemoteError:  # the answer cannot be read: the server may have accepted the goal
            self._core.discard_goal(self._record, '')
            if not self._keep:
                self._core.cancel_quietly(self._id)
            raise
        assert handle is not None
        assert attempt is not None
        attempt.see_servers(self._core.goal_service)
        if not handle.accepted:
            why = ', or knows its id already: ask with probe()' if self._has_own_id else ''
            raise attempt.error(GoalRefused, f'the server refused the goal{why}')
        self._ask_result(attempt)

    def _ask_result(self, attempt: CallContext) -> None:
        self._answer = self._core.get_result(self._id, attempt)
        self._answer.add_waker(self._stream.close)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if self._answer is not None and self._answer.pending() and not self._keep:
                await self._stop(self._limit())
        finally:
            if self._alarm is not None:
                self._alarm.cancel()
            if self._heartbeat is not None:
                self._heartbeat.close()
            if self._watch is not None:
                self._watch.close()
            self._discard()

    # -- its end -------------------------------------------------------------------------------------------

    def _limit(self) -> CallContext:
        return CallContext(self._core.node.context, 'action', self._core.full_name, self._limits.grace)

    def _discard(self) -> None:
        """Drop the feedback, and stop waiting for the result, of a goal that goes on."""
        self._stream.discard()
        answer = self._answer
        if answer is not None:
            # Read the outcome when it comes, so that Python does not warn of an exception never retrieved.
            answer.add_waker(partial(_look_at, answer))
            answer.cancel()

    async def _cancel_late(self, sending: Future[ClientGoalHandle[Any, Any, Any]]) -> None:
        """Cancel the goal if its server accepts it too late, when nobody waits for it any more."""
        limit = self._limit()
        try:
            await limit.settle(sending)
            self._take(sending)
        except DeadlineError:
            self._core.cancel_sending(sending)
        except (CallError, ClosedError, RemoteError):
            return  # the goal was refused, its server has gone, or the answer cannot be read
        else:
            await self._stop(limit)

    def _on_stuck(self) -> None:
        """End the run, since the server has been silent too long.

        Without `keep` the server is asked to cancel the goal, in case that it wakes up.
        """
        attempt, answer = self._attempt, self._answer
        assert attempt is not None
        assert answer is not None
        if answer.pending():
            silence = f'the server has given no sign of life for {self._limits.heartbeat} s'
            answer.set_exception(attempt.error(ServerStuckError, silence))
            if not self._keep:
                self._core.cancel_quietly(self._id)

    async def _stop(self, limit: CallContext) -> None:
        """Cancel the goal and wait for its end."""
        assert self._answer is not None
        try:
            if not await self._cancel(limit) and self._answer.pending():
                self._warn('the server does not cancel the goal: it goes on')
                return
            await limit.settle(self._answer)
        except (DeadlineError, ShutDownError) as error:
            self._warn(f'a goal that was cancelled did not end ({error})')
        except (CallError, ClosedError):
            return  # the server has gone, and the goal with it

    async def _cancel(self, attempt: CallContext) -> bool:
        asked = self._core.cancel_goal(self._id, call_context=attempt)
        try:
            if not await settle(asked, attempt.context.shutdown_signal):
                raise attempt.end_error()
            response: Any = asked.result()
        finally:
            if asked.pending():
                asked.cancel()
        return any(bytes(goal.goal_id.uuid) == self._id for goal in response.goals_canceling)

    def _warn(self, what: str) -> None:
        get_logger(self._core.node.logger_name).warning(f"Action '{self._core.full_name}': {what}")

    async def wait(self, *, timeout: float | None = None) -> ResultT:
        """Wait for the result, as `await run.result` does.

        With `timeout` the wait may take so many seconds from now, also beyond the limit of the whole run: a
        goal that was cancelled at that limit has still to end.
        """
        attempt, answer = self._attempt, self._answer
        if attempt is None or answer is None:
            raise ClosedError("a run's result is there only in its block: async with client.send(…) as run:")
        limit = attempt
        if timeout is not None:
            limit = CallContext(attempt.context, 'action', self._core.full_name, timeout)
        try:
            await limit.settle(answer)
            if answer.cancelled():
                raise ClosedError(
                    "the run's block was left while the goal went on: nobody waits for the result any more"
                )
            response: Any = answer.result()
        except CallError as error:
            raise attempt.retell(error) from None
        if response.status == GoalStatus.SUCCEEDED:
            result: ResultT = response.result
            return result
        raise _failure(attempt, response, self._record.reason)


def _refuse_known_id(core: ActionClientCore, goal_id: GoalId) -> None:
    """Raise GoalIdTaken for an id that was seen before.

    A server must not get a known id again. In rclcpp it would end the executor with an exception. A server
    that has dropped the result already would run the goal a second time.
    """
    known = core.goals.find(goal_id)
    if core.streams.published_status(goal_id) or (known is not None and (known.sent_at or known.status)):
        raise GoalIdTaken(goal_id, 'was sent before: follow it with attach(), or send under another id')


def _look_at(future: Future[Any]) -> None:
    future.exception()


def _failure(attempt: CallContext, response: Any, reason: str) -> CallError:
    """Return the error for a result whose status is not SUCCEEDED."""
    failure: GoalFailed
    if reason == SERVER_DIED:
        return attempt.error(ServerLostError, f'the goal has no result: {reason}')
    if response.status == GoalStatus.ABORTED:
        why = f': {reason}' if reason else ''
        failure = attempt.error(GoalAborted, f'the goal was aborted{why}')
    elif response.status == GoalStatus.CANCELED:
        failure = attempt.error(GoalCanceled, 'the goal was cancelled')
    else:
        return attempt.error(ServerLostError, 'the server does not know the goal any more')
    failure.result = response.result
    return failure


class _Result(Generic[ResultT]):
    """An awaitable for a run's result, which can be awaited several times."""

    def __init__(self, run: Run[ResultT, Any]) -> None:
        self._run = run

    def __await__(self) -> Generator[Any, None, ResultT]:
        return self._run.wait().__await__()


class _Feedback(Generic[FeedbackT]):
    """The feedback of one goal, decoded when the program asks for it."""

    def __init__(self, core: ActionClientCore, stream: AsyncQueue[Sample]) -> None:
        self._core = core
        self._stream = stream
        # Decodes only the feedback itself; the message around it holds also the goal id, which nobody reads.
        self._decode: Callable[[bytes], FeedbackT] = codec.decoder(core.support.cls.Feedback)  # type: ignore[attr-defined]

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> FeedbackT:
        while True:
            sample = await anext(self._stream)
            try:
                feedback = self._decode(unwrap(sample.payload)[1])
            except RemoteError as error:
                self._core.streams.reject_feedback(error)
            else:
                return feedback


class Heartbeat:
    """Calls `stuck` once, in the loop, when a goal's server was silent for `period` s.

    A sign of life only reads the clock; the timer is set again only when it fires. Silence is ignored while
    the goal waits for its turn (ACCEPTED).
    """

    def __init__(
        self, period: float, goal: ClientGoal[Any], clock: SteadyClock, stuck: Callable[[], object]
    ) -> None:
        self._period_ns = timeout_ns(period)
        self._goal = goal
        self._clock = clock
        self._stuck = stuck
        self._heard = clock.now()
        self._loop = asyncio.get_running_loop()
        self._timer = self._loop.call_later(delay_s(self._period_ns), self._look)
        goal.heard = self._hear

    def _hear(self) -> None:
        """Note a sign of life. Any thread may call this."""
        self._heard = self._clock.now()

    def _look(self) -> None:
        if self._goal.status is GoalStatus.ACCEPTED:
            self._hear()
        left = self._heard + self._period_ns - self._clock.now()
        if left > 0:
            self._timer = self._loop.call_later(delay_s(left), self._look)
        else:
            self.close()
            self._stuck()

    def close(self) -> None:
        """Stop watching. Idempotent."""
        self._goal.heard = None
        self._timer.cancel()
