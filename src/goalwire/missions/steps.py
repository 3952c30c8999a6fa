"""The first argument of a mission's code. Everything that the code does is a step in the journal."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Generic, NoReturn, Protocol, TypeVar

from goalwire.aio.entity import message_of
from goalwire.cdr import codec
from goalwire.errors import CallError, GoalFailed, MissionError, MissionStopped
from goalwire.missions import plain_steps
from goalwire.missions.call_step import CallRequest, CallStep
from goalwire.missions.goal_step import GoalRequest, GoalStep
from goalwire.missions.journal_store import as_json
from goalwire.missions.live_step import IfLost, LiveStep, check_if_lost
from goalwire.missions.outcomes import Outcome, outcome_of
from goalwire.missions.parallel_goal_steps import SentGoal
from goalwire.missions.undo import Undo
from goalwire.rules.missions.entries import StepKey, digest_of
from goalwire.rules.missions.replay import DoesNotFit, Replay, StepHistory
from goalwire.rules.missions.unknown_goals import KEPT_S

if TYPE_CHECKING:
    import goalwire
    from goalwire.entities.actions.types import ActionClass
    from goalwire.entities.type_support import ServiceClass

MsgT = TypeVar('MsgT')
RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')
GoalT = TypeVar('GoalT')
ResultT = TypeVar('ResultT')
FeedbackT = TypeVar('FeedbackT')

Perform = Callable[[LiveStep], Awaitable[Outcome]]


class Performer(Protocol):
    """Carries out steps that have not ended in the journal."""

    async def perform(
        self, history: StepHistory, how: Perform, *, is_undoing: bool, always_begins: bool
    ) -> Outcome: ...


class Steps:
    """The steps of one mission. Everything that the mission does or reads is a step, one after the other.

    After a restart the mission's code runs from the beginning again, and every step that has ended takes its
    outcome from the journal at once. So the code must not depend on clocks, random numbers or files directly;
    `now`, `random` and `run` are for these.
    """

    def __init__(self, mission_id: str, performer: Performer, replay: Replay) -> None:
        self.id = mission_id
        """The mission's id."""
        self._performer = performer
        self._replay = replay
        self._undoing = 0
        self._task = asyncio.current_task()
        self._does_not_fit: DoesNotFit | None = None

    # -- steps ---------------------------------------------------------------------------------------------

    def action(
        self,
        action_type: ActionClass[GoalT, ResultT, FeedbackT],
        name: str,
        *,
        if_lost: IfLost = 'ask',
        kept: float = KEPT_S,
    ) -> ActionSteps[GoalT, ResultT]:
        """Return an object that sends goals of an action, each as a step.

        `if_lost` says what to do about a goal that may have run: ask a person ('ask'), send it 'again', treat
        it as 'done', let the step 'fail' with StepLost, or `async def check(node, goal)`, which looks at the
        world and returns True if the goal is done. `kept` is the least time in s for which the server keeps
        results.
        Raises ValueError for another `if_lost`.
        """
        check_if_lost(if_lost)
        return ActionSteps(self, action_type, name, if_lost, kept)

    def client(
        self,
        service_type: ServiceClass[RequestT, ResponseT],
        name: str,
        *,
        idempotent: bool = False,
        if_lost: IfLost = 'ask',
    ) -> CallSteps[RequestT, ResponseT]:
        """Return an object that calls a service, each call as a step.

        An `idempotent` service is called again if it is unknown whether the call has happened. For others
        `if_lost` applies as for `action`. Raises ValueError for another `if_lost`.
        """
        check_if_lost(if_lost)
        return CallSteps(self, service_type, name, if_lost, idempotent)

    async def wait(
        self,
        message_type: type[MsgT],
        topic: str,
        condition: Callable[[MsgT], object] | None = None,
        *,
        timeout: float | None = None,
        qos: goalwire.QoS | int = 10,
    ) -> MsgT:
        """Wait for a message that meets the condition, and return it.

        Raises DeadlineError after `timeout` s, StepFailed if the condition raises.
        """
        key = StepKey('wait', topic, digest_of(message_type.__name__, repr(timeout)))

        def how(step: LiveStep) -> Awaitable[Outcome]:
            return plain_steps.wait_for_message(step, message_type, topic, condition, timeout, qos)

        message: MsgT = await self.step(key, how, message_type)
        return message

    async def sleep(self, seconds: float) -> None:
        """Sleep for `seconds`, including the time without a runner."""
        key = StepKey('sleep', f'{seconds} s', '')
        await self.step(key, lambda step: plain_steps.sleep(step, seconds))

    async def sleep_until(self, when: float) -> None:
        """Sleep until the system's clock shows `when`, in s since 1970."""
        key = StepKey('sleep until', f'{when}', '')
        await self.step(key, lambda step: plain_steps.sleep_until(step, when))

    async def approve(self, question: str, *, timeout: float | None = None) -> bool:
        """Ask a person, who answers by `goalwire mission approve` or Runner.approve.

        No answer within `timeout` s counts as no.
        """
        key = StepKey('approve', '', digest_of(question, repr(timeout)))
        return bool(await self.step(key, lambda step: plain_steps.approve(step, question, timeout)))

    async def run(self, function: Callable[..., Any], *arguments: Any, timeout: float | None = None) -> Any:
        """Call your own function, plain or `async def`, and return its value, which must fit into JSON.

        It runs at least once. It runs again if the runner ended before the value was in the journal. Raises
        StepFailed if it raises.
        """
        name = getattr(function, '__name__', 'function')
        key = StepKey('run', name, digest_of(as_json(list(arguments))))
        return await self.step(
            key, lambda step: plain_steps.call_function(step, function, arguments, timeout)
        )

    async def now(self) -> float:
        """Return the time in s since 1970 at which the mission first called this step."""

        async def look(step: LiveStep) -> Outcome:
            return Outcome(step.computer.wall())

        return float(await self.step(StepKey('now', '', ''), look))

    async def random(self) -> float:
        """Return a random number from 0 to 1, the same after a restart."""

        async def roll(_step: LiveStep) -> Outcome:
            return Outcome(random.random())  # noqa: S311 - no secret

        return float(await self.step(StepKey('random', '', ''), roll))

    # -- endings -------------------------------------------------------------------------------------------

    def undo(self) -> Undo:
        """Return a context manager. If its block fails, the steps pushed to it run in reverse order."""
        return Undo(self.undoing)

    def give_up(self, reason: str) -> NoReturn:
        """End the mission as failed; undo steps run. Raises MissionStopped."""
        raise MissionStopped(reason)

    # -- how a step goes -----------------------------------------------------------------------------------

    async def step(
        self,
        key: StepKey,
        how: Perform,
        message_type: type | None = None,
        *,
        always_begins: bool = False,
    ) -> Any:
        """Return the step's outcome from the journal, or carry the step out now.

        With `always_begins`, it begins although the mission was stopped, and is interrupted by that.
        """
        if asyncio.current_task() is not self._task:
            raise MissionError(
                f'{key}: a mission does one step after the other; call its steps in its own task, '
                'not in those that it made (asyncio.gather, create_task)'
            )
        if self._does_not_fit is not None:
            raise self._does_not_fit
        try:
            history = self._replay.begin(key)
            ended = history.ended
            if ended is not None:
                outcome = outcome_of(ended, message_type)
            else:
                outcome = await self._performer.perform(
                    history, how, is_undoing=self._undoing > 0, always_begins=always_begins
                )
        except DoesNotFit as error:
            self._does_not_fit = error
            raise
        return outcome.take()

    @contextmanager
    def undoing(self) -> Iterator[None]:
        """Return a context manager: steps in its block run although the mission was stopped."""
        self._undoing += 1
        try:
            yield
        finally:
            self._undoing -= 1


class ActionSteps(Generic[GoalT, ResultT]):
    """Sends goals of one action as steps. Steps.action makes it."""

    def __init__(self, steps: Steps, action_type: Any, name: str, if_lost: IfLost, kept: float) -> None:
        self._steps = steps
        self._type = action_type
        self._name = name
        self._if_lost = if_lost
        self._kept = kept

    async def call(
        self,
        goal: GoalT | None = None,
        /,
        *,
        timeout: float | None = None,
        attempts: int = 1,
        pause: float = 1.0,
        **fields: object,
    ) -> ResultT:
        """Send a goal, wait for its result, and return it.

        The goal is cancelled after `timeout` s, including the wait for the server. A failed goal is sent
        again as a new goal, up to `attempts` times in all, with `pause` s between them. The default is one
        attempt: the goal may have failed because somebody else has taken control of the robot. Raises
        GoalAborted, GoalCanceled, GoalRefused, NoServerError, DeadlineError; StepLost.
        """
        request, digest = self._request(goal, fields, timeout)
        key = StepKey('goal', self._name, digest)

        async def once() -> ResultT:
            result: ResultT = await self._steps.step(
                key, lambda step: GoalStep(step, request).perform(), self._type.Result
            )
            return result

        return await _attempt(self._steps, once, attempts, pause)

    def send(
        self, goal: GoalT | None = None, /, *, timeout: float | None = None, **fields: object
    ) -> SentGoal[ResultT]:
        """Return a goal that goes on while other steps follow: `async with drive.send(order=1) as sent:`.

        Entering the block sends the goal, and waits until it is accepted, `timeout` s at most, including the
        wait for the server. `await sent.result()` is a step of its own. Entering raises GoalRefused,
        NoServerError, DeadlineError; StepLost.
        """
        request, digest = self._request(goal, fields, timeout)
        return SentGoal(request, digest, self._steps.step, self._steps.undoing)

    def _request(
        self, goal: GoalT | None, fields: dict[str, object], timeout: float | None
    ) -> tuple[GoalRequest, str]:
        """Return the request for a goal, and the hash by which the journal knows it."""
        message = message_of(self._type.Goal, goal, fields)
        digest = digest_of(self._type.__name__, codec.encode(message), repr(timeout))
        return GoalRequest(self._type, self._name, message, timeout, self._if_lost, self._kept), digest


class CallSteps(Generic[RequestT, ResponseT]):
    """Calls one service, each time as a step. Steps.client makes it."""

    def __init__(self, steps: Steps, service_type: Any, name: str, if_lost: IfLost, idempotent: bool) -> None:
        self._steps = steps
        self._type = service_type
        self._name = name
        self._if_lost = if_lost
        self._idempotent = idempotent

    async def call(
        self,
        request: RequestT | None = None,
        /,
        *,
        timeout: float | None = None,
        attempts: int = 1,
        pause: float = 1.0,
        **fields: object,
    ) -> ResponseT:
        """Call the service and return its response, within `timeout` s, including the wait for the server.

        If an idempotent call fails, it is made again, up to `attempts` times in all, with `pause` s between
        them. Raises NoServerError, DeadlineError, RefusedError, ServerFailedError, ServerLostError; StepLost;
        ValueError for several attempts of a call that is not idempotent.
        """
        if attempts > 1 and not self._idempotent:
            raise ValueError(
                f"service '{self._name}': a call that failed may have happened, so only an idempotent one "
                'has several attempts'
            )
        message = message_of(self._type.Request, request, fields)
        key = StepKey(
            'call', self._name, digest_of(self._type.__name__, codec.encode(message), repr(timeout))
        )
        asked = CallRequest(self._type, self._name, message, timeout, self._if_lost, self._idempotent)

        async def once() -> ResponseT:
            response: ResponseT = await self._steps.step(
                key, lambda step: CallStep(step, asked).perform(), self._type.Response
            )
            return response

        return await _attempt(self._steps, once, attempts, pause)


async def _attempt(
    steps: Steps, once: Callable[[], Awaitable[ResultT]], attempts: int, pause: float
) -> ResultT:
    """Do a step until it succeeds, `attempts` times at most, with `pause` s between them."""
    if attempts < 1:
        raise ValueError(f'attempts is at least 1, not {attempts}')
    for _ in range(attempts - 1):
        try:
            return await once()
        except (GoalFailed, CallError):
            await steps.sleep(pause)
    return await once()
