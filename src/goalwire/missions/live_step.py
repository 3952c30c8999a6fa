"""The common part of all steps that are being carried out."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

import goalwire
from goalwire.errors import DeadlineError
from goalwire.rules.missions.entries import Decision, Entry, EntryKind, MissionState
from goalwire.rules.missions.replay import StepHistory

if TYPE_CHECKING:
    from goalwire.missions.mission_run_contract import RunningMission
    from goalwire.rules.missions.entries import Json

T = TypeVar('T')

PAUSE_S = 1.0
"""The pause, in s, before a server is asked again, if its answer allows no conclusion."""


class Interrupted(Exception):
    """Raised in a step that must end early: the mission is stopped, or the step's time is over."""

    def __init__(self, error: Exception, *, is_stop: bool) -> None:
        super().__init__(str(error))
        self.error = error
        """The error that the step then raises in the mission."""
        self.is_stop = is_stop


class LiveStep:
    """One step of one mission, from its intent to its end."""

    def __init__(self, run: RunningMission, history: StepHistory, *, is_undoing: bool) -> None:
        self._run = run
        self._ignores_stop = is_undoing
        self.history = history
        self.number = history.number
        self.node: goalwire.Node = run.node
        self.computer = run.computer
        self.clients = run.clients
        self.must_probe = run.take_suspicion()
        """True if the journal may have lost its last commit, since the machine was restarted."""
        self._deadline: float | None = None

    @property
    def title(self) -> str:
        """The step's name for people."""
        return f'step {self.number + 1}, {self.history.key}'

    def goal_id(self, attempt: int) -> bytes:
        """Return the id of this step's goal. It is the same in every life of the mission."""
        return self._run.goal_id(self.number, attempt)

    # -- writing -------------------------------------------------------------------------------------------

    async def begin(self, timeout: float | None, facts: dict[str, Json], data: bytes = b'') -> Entry:
        """Write the step's intent, and set its time limit."""
        begun = self.computer.sighting()
        body: dict[str, Json] = {
            **self.history.key.facts,
            'boot': begun.boot,
            'steady': begun.steady,
            'wall': self.computer.wall(),
            **facts,
        }
        entry = Entry(EntryKind.INTENT, self.number, body, data)
        await self.write(entry)
        self.limit(entry, timeout)
        return entry

    async def write(self, entry: Entry, state: MissionState | None = None, why: str = '') -> None:
        """Write an entry of this step."""
        await self._run.write(entry, state=state, why=why)

    def boundary(self, name: str) -> None:
        """Report a place in the code to the test kit, which may let the program crash there."""
        self._run.boundary(name, self.title)

    # -- time ----------------------------------------------------------------------------------------------

    def age(self, intent: Entry) -> float | None:
        """Return how many s ago an intent was written; None if the machine was restarted since then."""
        if intent.body.get('boot') != self.computer.boot:
            return None
        return self.computer.steady() - float(str(intent.body['steady']))

    def limit(self, intent: Entry, timeout: float | None) -> None:
        """Give the step `timeout` s since its intent, by the system's clock if the machine was restarted."""
        if timeout is None:
            return
        age = self.age(intent)
        if age is None:
            age = self.computer.wall() - float(str(intent.body['wall']))
        self._deadline = self.computer.steady() + timeout - max(age, 0.0)

    def measure_left(self) -> float | None:
        """Return how many s are left; None if the step has no limit."""
        return None if self._deadline is None else max(self._deadline - self.computer.steady(), 0.0)

    def lift_limit(self) -> None:
        """Remove the step's time limit, for example since it has passed and the goal is being cancelled."""
        self._deadline = None

    def ignore_stop(self) -> None:
        """Let the step go on although the mission is stopped, so that it can cancel its goal."""
        self._ignores_stop = True

    async def send(self, sending: Awaitable[T]) -> asyncio.Future[T]:
        """Begin to send, in a task whose first turn puts the request on the wire; return the task.

        Its error is taken even if the step ends before it waits for the task: asyncio would log it.
        """
        task = asyncio.ensure_future(sending)
        task.add_done_callback(_take_error)
        await asyncio.sleep(0)  # the first turn
        return task

    async def until_stopped(self, awaitable: Awaitable[T], *, is_limited: bool = True) -> T:
        """Wait for something; raises Interrupted if the mission is stopped.

        With `is_limited`, it is also raised when the step's time limit is over.
        """
        task = asyncio.ensure_future(awaitable)
        stop = asyncio.ensure_future(self._run.stop_requested.wait())
        waiting: list[asyncio.Future[Any]] = [task] if self._ignores_stop else [task, stop]
        try:
            await asyncio.wait(
                waiting,
                timeout=self.measure_left() if is_limited else None,
                return_when=asyncio.FIRST_COMPLETED,
            )
            if task.done():
                return task.result()
            if stop.done() and not self._ignores_stop:
                raise Interrupted(self._run.make_stop_error(), is_stop=True)
            raise Interrupted(DeadlineError(f'{self.title}: its time is over'), is_stop=False)
        finally:
            await _end(stop)
            await _end(task)

    async def pause(self, why: str) -> None:
        """Show why the step cannot go on, and wait a moment."""
        await self._run.tell(why)
        await self.until_stopped(asyncio.sleep(PAUSE_S))

    # -- people --------------------------------------------------------------------------------------------

    async def ask(self, state: MissionState, question: str) -> str:
        """Ask a person, once in all lives of the mission, and wait until the journal has the answer. Raises
        Interrupted.
        """
        answer = self._run.expect_answer(self.number)
        try:
            known = StepHistory(self.number, self.history.key, self._run.entries_of(self.number))
            answered = known.since_intent(EntryKind.ANSWERED)
            if answered is not None:  # answered before a restart, or before the step came here
                return str(answered.body['answer'])
            asked = known.since_intent(EntryKind.ASKED)
            entries = () if asked else (Entry(EntryKind.ASKED, self.number, {'question': question}),)
            await self._run.write(*entries, state=state, why=question)
            return await self.until_stopped(answer)
        finally:
            self._run.expect_no_answer()

    async def decide_lost(self, if_lost: IfLost, request: object, evidence: str) -> Decision:
        """Decide, as `if_lost` says, about a step that may have happened. Raises Interrupted."""
        question = f'{self.title}: {evidence}'
        if if_lost == 'ask':
            return Decision(await self.ask(MissionState.LOST, question))
        if isinstance(if_lost, str):
            decision = Decision(if_lost)
        else:
            happened = await self.until_stopped(if_lost(self.node, request))
            decision = Decision.DONE if happened else Decision.AGAIN
        await self.write(Entry(EntryKind.NOTE, self.number, {'text': f'{question}: {decision} (if_lost)'}))
        return decision


IfLost = str | Callable[[goalwire.Node, Any], Awaitable[bool]]
"""The policy for a lost step: 'ask', 'again', 'done', 'fail', or `async def check(node, request)`, which
returns True if the step has happened."""


def check_if_lost(given: IfLost) -> None:
    """Raise ValueError for a policy that does not exist."""
    if not callable(given) and given != 'ask' and given not in set(Decision):
        raise ValueError(f"if_lost is 'ask', 'again', 'done', 'fail' or a coroutine function, not {given!r}")


async def _end(task: asyncio.Future[Any]) -> None:
    """Cancel a task and wait until it ends; ignore its error."""
    if not task.done():
        task.cancel()
        with suppress(asyncio.CancelledError):
            await asyncio.wait([task])
    _take_error(task)


def _take_error(task: asyncio.Future[Any]) -> None:
    """Take the error of a task that has ended, if it has one: nobody else waits for it."""
    if not task.cancelled():
        task.exception()
