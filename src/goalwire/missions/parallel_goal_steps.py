"""Goals that go on while their mission does other steps: one step sends a goal, a later one takes its result.

So two goals can run side by side although a mission does one step after the other. Sending, cancelling and
the result are three kinds of steps, and each of them goes on after a restart like every other step.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import AbstractContextManager, suppress
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from goalwire.errors import CallError, MissionError, MissionStopped, StepFailed, StepLost
from goalwire.missions.goal_step import CANCEL_S, GoalRequest, GoalRun, GoalStep, Move
from goalwire.missions.live_step import Interrupted, LiveStep
from goalwire.missions.outcomes import Outcome
from goalwire.records import replace
from goalwire.rules.missions.entries import StepKey, digest_of

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    import goalwire
    from goalwire.rules.missions.entries import Json

ResultT = TypeVar('ResultT')


class SentGoal(Generic[ResultT]):
    """A goal that goes on in the block: `async with drive.send(order=1) as sent:`. ActionSteps.send makes it.

    If the block is left before the result was taken, the goal is cancelled, and the mission waits for its
    end. The goal goes on if only the runner or the machine ends.
    """

    def __init__(
        self,
        request: GoalRequest,
        digest: str,
        step: Callable[..., Awaitable[Any]],
        undoing: Callable[[], AbstractContextManager[None]],
    ) -> None:
        """`step` does a step. `undoing()` is a context manager: steps in its block run although the mission
        was stopped.
        """
        self._request = request
        self._digest = digest
        self._step = step
        self._undoing = undoing
        self._goal_id = ''
        self._is_done = False
        self._is_cancelled = False
        self._outcome: Outcome | None = None

    async def __aenter__(self) -> Self:
        request = self._request
        key = StepKey('send', request.name, self._digest)
        sent = await self._step(key, lambda step: _SendStep(step, request).perform())
        self._goal_id, self._is_done = sent['goal_id'], sent['is_done']
        return self

    async def result(self, *, timeout: float | None = None) -> ResultT:
        """Wait for the result, and return it, also several times.

        The goal is cancelled if the result does not come within `timeout` s from the first call on. Raises
        GoalAborted, GoalCanceled, DeadlineError; StepLost.
        """
        if self._outcome is None:
            await self._take_result(replace(self._request, timeout=timeout))
        assert self._outcome is not None
        result: ResultT = self._outcome.take()
        return result

    async def cancel(self) -> None:
        """Ask the server to cancel the goal. The result tells how the goal ended.

        Raises DeadlineError, NoServerError, ServerLostError, ServerFailedError.
        """
        request, goal_id = self._request, self._known_id()
        key = StepKey('cancel', request.name, digest_of(goal_id))
        await self._step(key, lambda step: _cancel(step, request, bytes.fromhex(goal_id)))
        self._is_cancelled = True

    def _known_id(self) -> str:
        if not self._goal_id:
            raise MissionError(
                f"action '{self._request.name}': the goal is sent by `async with`: "
                'async with drive.send(…) as sent:'
            )
        return self._goal_id

    async def _take_result(self, request: GoalRequest, *, is_leaving: bool = False) -> None:
        goal_id = self._known_id()
        key = StepKey('result', request.name, digest_of(goal_id, repr(request.timeout)))

        def how(step: LiveStep) -> Awaitable[Outcome]:
            goal = bytes.fromhex(goal_id)
            return _ResultStep(step, request, goal, is_done=self._is_done, is_leaving=is_leaving).perform()

        # The step begins although the mission was stopped: it then cancels the goal. So each of these errors
        # says how the goal ended. After any other error the goal goes on until the block is left.
        try:
            result = await self._step(key, how, request.action_type.Result, always_begins=True)
            self._outcome = Outcome(result)
        except (CallError, MissionStopped, StepFailed, StepLost) as error:
            self._outcome = Outcome(error=error)

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._outcome is not None or not (error is None or isinstance(error, Exception)):
            return  # the goal has ended, or the runner is ending
        with self._undoing():
            if not self._is_cancelled:
                with suppress(CallError):
                    await self.cancel()
            request = replace(self._request, timeout=CANCEL_S, if_lost='fail')
            await self._take_result(request, is_leaving=True)


class _SendStep(GoalStep):
    """Sends a goal. It ends when the goal is accepted; its value has the goal's id."""

    _is_kept = False

    async def _watch(self, run: GoalRun, entering: Awaitable[Any]) -> Outcome | None:
        await self._step.until_stopped(entering)
        if self._interruption is not None:
            return await self._cancel(run)
        self._is_kept = True
        return self._conclude_acceptance()

    async def _leave(self, run: GoalRun) -> None:
        if self._is_kept:
            self._step.clients.sent[self._goal_id] = run
        else:
            await super()._leave(run)

    def _conclude_end(self, found: goalwire.GoalProbe[Any]) -> Outcome:
        return super()._conclude_end(found) if self._interruption is not None else self._conclude_acceptance()

    def _conclude_success(self, result: object) -> Outcome:  # noqa: ARG002 - the step `result` takes it
        return self._conclude_acceptance()

    def _conclude_done(self) -> Outcome:
        return self._conclude_acceptance(is_done=True)

    def _conclude_acceptance(self, *, is_done: bool = False) -> Outcome:
        value: dict[str, Json] = {'goal_id': self._goal_id.hex(), 'is_done': is_done}
        return Outcome(value)


class _ResultStep(GoalStep):
    """Waits for the end of a goal that an earlier step has sent."""

    def __init__(
        self, step: LiveStep, request: GoalRequest, goal_id: bytes, *, is_done: bool, is_leaving: bool
    ) -> None:
        """With `is_leaving` the goal was cancelled, and a server that has gone is not waited for."""
        super().__init__(step, request)
        self._first_id = goal_id
        self._is_done = is_done
        self._is_leaving = is_leaving

    @property
    def _goal_id(self) -> bytes:
        return self._first_id if self._attempt == 1 else super()._goal_id

    @property
    def _may_give_up(self) -> bool:
        return super()._may_give_up or (self._is_leaving and self._interruption is not None)

    async def perform(self) -> Outcome:
        """Return the goal's outcome."""
        if self._is_done:
            return self._conclude_done()
        return await super().perform()

    async def _open(self) -> Move:
        if self._intent is not None:
            return await super()._open()
        await self._write_intent()
        return Move.ASK if self._step.must_probe else Move.FOLLOW

    async def _attach(self) -> tuple[GoalRun, asyncio.Future[Any]]:
        run = self._step.clients.sent.pop(self._goal_id, None)
        if run is None:
            return await super()._attach()
        entered = asyncio.get_running_loop().create_future()
        entered.set_result(run)
        return run, entered

    async def _conclude_unknown(self, journal: str) -> Outcome | Move | None:
        if self._attempt > 1:
            return await super()._conclude_unknown(journal)
        return await self._conclude_lost('the server had accepted it, and does not have it any more')


async def _cancel(step: LiveStep, request: GoalRequest, goal_id: bytes) -> Outcome:
    """Ask a goal's server to cancel it. To ask twice does no harm: after a restart it may refuse, since the
    goal has been cancelled already.
    """
    if step.history.intent is None:
        await step.begin(None, {'goal_id': goal_id.hex()})
    step.boundary('before send')
    asking = await step.send(_ask_to_cancel(step, request, goal_id))
    step.boundary('after send')
    try:
        await step.until_stopped(asking)
        return Outcome()
    except CallError as error:
        return Outcome(error=error)
    except Interrupted as why:
        return Outcome(error=why.error)


async def _ask_to_cancel(step: LiveStep, request: GoalRequest, goal_id: bytes) -> None:
    run = step.clients.sent.get(goal_id)
    if run is not None:
        await run.cancel(timeout=CANCEL_S)
        return
    client = step.clients.action(request.action_type, request.name)
    await client.wait_for_server(timeout=CANCEL_S)
    async with client.attach(goal_id) as attached:
        await attached.cancel(timeout=CANCEL_S)
