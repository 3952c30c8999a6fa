"""A goal as a step. The goal is sent only once; if it is uncertain whether it was sent, a person is asked.

The journal has the intent before the goal is sent, with the server's state at that moment. If the answer is
missing because the runner or the server was restarted, or the link was cut, the server is asked about the
goal. The goal is sent again only if it is certain that it never arrived, and then with the same id.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from contextlib import suppress
from enum import Enum, auto
from typing import Any, TypeAlias

import goalwire
from goalwire.errors import (
    CallError,
    DeadlineError,
    GoalAborted,
    GoalCanceled,
    GoalFailed,
    GoalIdTaken,
    GoalRefused,
    NoServerError,
    StepLost,
)
from goalwire.missions.live_step import IfLost, Interrupted, LiveStep
from goalwire.missions.outcomes import Outcome, encode_message
from goalwire.records import record
from goalwire.rules.goals.server_snapshot import ServerSnapshot
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.missions.entries import Decision, Entry, EntryKind
from goalwire.rules.missions.unknown_goals import Whereabouts, judge

CANCEL_S = 10.0
"""How long, in s, a cancelled goal may take to end before the mission goes on without it."""


GoalRun: TypeAlias = 'goalwire.Run[Any, Any]'
"""A goal that this runner has sent, or has attached to."""


class Move(Enum):
    """The next thing to do about the goal."""

    SEND = auto()
    ASK = auto()
    FOLLOW = auto()


@record
class GoalRequest:
    """A mission's request to carry out a goal of an action."""

    action_type: Any
    name: str
    goal: Any
    timeout: float | None
    if_lost: IfLost
    kept: float
    """How long, in s, the server keeps results at least."""


class GoalStep:
    """Carries out one goal, or goes on with it from the state in the journal."""

    def __init__(self, step: LiveStep, request: GoalRequest) -> None:
        self._step = step
        self._request = request
        self._client = step.clients.action(request.action_type, request.name)
        self._intent: Entry | None = step.history.intent
        self._attempt = max(step.history.attempts, 1)
        self._interruption: Interrupted | None = None
        self._refusal: GoalRefused | None = None
        self._journal = ''
        """The id of the server's journal of goals, if it has one."""
        self._may_be_known = self._intent is not None or step.must_probe
        """True if a server may know the id already: then a refusal does not mean that the goal did not
        run."""

    @property
    def _goal_id(self) -> bytes:
        return self._step.goal_id(self._attempt)

    async def perform(self) -> Outcome:
        """Return the goal's outcome: as the server reports it, or as the mission or a person decides."""
        try:
            move = await self._open()
        except (Interrupted, NoServerError) as error:  # nothing was sent
            return Outcome(error=error.error if isinstance(error, Interrupted) else error)
        while True:
            found: Outcome | Move
            if move is Move.ASK:
                found = await self._find_out()
            else:
                found = await self._follow(again=move is Move.FOLLOW) or Move.ASK
            if isinstance(found, Outcome):
                return found
            move = found

    # -- the intent ----------------------------------------------------------------------------------------

    async def _open(self) -> Move:
        """Write the intent and choose to send; if the journal has an intent, choose to ask the server."""
        step = self._step
        if self._intent is not None:
            step.limit(self._intent, self._request.timeout)
            if step.history.since_intent(EntryKind.CANCEL) is not None:
                self._interruption = Interrupted(
                    DeadlineError(f'{step.title}: its time is over'), is_stop=False
                )
                step.lift_limit()
            return Move.ASK
        await self._wait_for_server()
        await self._write_intent()
        return Move.ASK if step.must_probe else Move.SEND

    async def _wait_for_server(self) -> None:
        limit = self._request.timeout
        await self._step.until_stopped(self._client.wait_for_server(timeout=limit))
        self._journal = await self._step.until_stopped(self._step.clients.journal(self._client))

    async def _write_intent(self) -> None:
        server = self._client.server_snapshot()
        facts, data = encode_message(self._request.goal)
        facts |= {
            'goal_id': self._goal_id.hex(),
            'servers': sorted(server.servers),
            'statuses': server.statuses,
            'journal': self._journal,
        }
        self._intent = await self._step.begin(self._request.timeout, facts, data)

    # -- sending and following -----------------------------------------------------------------------------

    async def _follow(self, *, again: bool) -> Outcome | None:
        """Send the goal, or attach to it, and wait for its end. Return None if the server must be asked."""
        was_known = again or self._may_be_known
        run, entering = await (self._attach() if again else self._send())
        if not again:
            self._step.boundary('after send')
        try:
            return await self._watch(run, entering)
        except GoalRefused as refusal:
            self._refusal = refusal
            return None if was_known else Outcome(error=refusal)
        except (CallError, GoalIdTaken):
            return None
        except Interrupted as why:
            await self._note_interruption(why)
            return None
        finally:
            if entering.done() and not entering.cancelled() and entering.exception() is None:
                await self._leave(run)

    async def _send(self) -> tuple[GoalRun, asyncio.Future[Any]]:
        self._step.boundary('before send')
        self._may_be_known = True
        run: GoalRun = self._client.send(self._request.goal, goal_id=self._goal_id, keep=True)
        return run, await self._step.send(run.__aenter__())

    async def _attach(self) -> tuple[GoalRun, asyncio.Future[Any]]:
        run: GoalRun = self._client.attach(self._goal_id)
        return run, await self._step.send(run.__aenter__())

    async def _leave(self, run: GoalRun) -> None:
        """End the run, not its goal: the result is not awaited any more."""
        await run.__aexit__(None, None, None)

    async def _watch(self, run: GoalRun, entering: Awaitable[Any]) -> Outcome | None:
        step = self._step
        await step.until_stopped(entering)
        if self._interruption is not None:
            return await self._cancel(run)
        try:
            return self._conclude_success(await step.until_stopped(run.result))
        except Interrupted as why:
            await self._note_interruption(why)
            return await self._cancel(run)
        except GoalFailed as failure:
            return self._conclude_failure(failure)

    async def _note_interruption(self, why: Interrupted) -> None:
        """Write that the goal will be cancelled, so that after a restart it is known who has cancelled it."""
        self._interruption = why
        self._step.lift_limit()
        if why.is_stop:
            self._step.ignore_stop()
        await self._step.write(Entry(EntryKind.CANCEL, self._step.number, {'why': str(why)}))

    async def _cancel(self, run: GoalRun) -> Outcome:
        """Cancel the goal, since its time is over or the mission is stopped."""
        assert self._interruption is not None
        with suppress(CallError):
            await run.cancel(timeout=CANCEL_S)
        try:
            async with asyncio.timeout(CANCEL_S):
                return self._conclude_success(await run.result)
        except GoalFailed as failure:
            return self._conclude_failure(failure)
        except (TimeoutError, CallError):
            return self._gave_up('it was cancelled, and the server did not say that it ended: it may go on')

    def _conclude_success(self, result: object) -> Outcome:
        return Outcome(result, message_type=self._request.action_type.Result)

    def _conclude_done(self) -> Outcome:
        """Return the outcome of a lost goal that counts as reached."""
        return self._conclude_success(self._request.action_type.Result())

    def _conclude_failure(self, failure: GoalFailed) -> Outcome:
        """Return the outcome of a failed goal: the mission's own error if the mission has cancelled it."""
        if self._interruption is not None and isinstance(failure, GoalCanceled):
            return Outcome(error=self._interruption.error)
        return Outcome(error=failure)

    @property
    def _may_give_up(self) -> bool:
        """True if the mission goes on without a server that cannot tell about the goal."""
        return self._interruption is not None and self._interruption.is_stop

    def _gave_up(self, why: str) -> Outcome:
        assert self._interruption is not None
        error = self._interruption.error
        error.args = (f'{error}; {why}', *error.args[1:])
        return Outcome(error=error)

    # -- asking the server ---------------------------------------------------------------------------------

    async def _find_out(self) -> Outcome | Move:
        """Ask the server for the goal's state until there is a conclusion."""
        while True:
            try:
                # Ask even after the step's time limit: a goal that has ended meanwhile counts as ended.
                asking = self._client.probe(self._goal_id)
                found = await self._step.until_stopped(asking, is_limited=False)
                conclusion = await self._conclude(found)
                if conclusion is not None:
                    return conclusion
                if self._may_give_up:
                    return self._gave_up(f'nobody can tell how its goal stands, it may go on: {found.why}')
                await self._step.pause(f'{self._step.title}: {found.why}')
            except Interrupted as why:
                await self._note_interruption(why)

    async def _conclude(self, found: goalwire.GoalProbe[Any]) -> Outcome | Move | None:
        """Return the outcome or next move for a server's answer; None if it must be asked again."""
        match found.state:
            case goalwire.GoalState.RUNNING:
                return Move.FOLLOW
            case goalwire.GoalState.ENDED | goalwire.GoalState.RESULT_GONE:
                return self._conclude_end(found)
            case goalwire.GoalState.SERVER_DIED:
                return await self._conclude_lost(found.why)
            case goalwire.GoalState.UNKNOWN:
                return await self._conclude_unknown(found.journal)
            case _:
                return None

    def _conclude_end(self, found: goalwire.GoalProbe[Any]) -> Outcome:
        if found.status is GoalStatus.SUCCEEDED:
            result = self._request.action_type.Result() if found.result is None else found.result
            return self._conclude_success(result)
        name = self._client.name
        failure: GoalFailed
        if found.status is GoalStatus.CANCELED:
            failure = GoalCanceled(f"action '{name}': the goal was cancelled", name=name)
        else:
            failure = GoalAborted(f"action '{name}': the goal was aborted", name=name)
        failure.result = found.result
        return self._conclude_failure(failure)

    async def _conclude_unknown(self, journal: str) -> Outcome | Move | None:
        """Conclude from the answer of a server that does not know the goal; `journal` is its journal's id."""
        assert self._intent is not None
        body = self._intent.body
        if journal and journal == body.get('journal'):
            return self._send_again()  # this server forgets no goal, so it never had this one
        servers = body['servers']
        sent = ServerSnapshot(
            frozenset(map(str, servers if isinstance(servers, list) else ())), str(body['statuses'])
        )
        where, why = judge(
            sent,
            self._client.server_snapshot(),
            listened=self._step.clients.measure_listening(self._client),
            age=self._step.age(self._intent),
            kept=self._request.kept,
        )
        if where is Whereabouts.TOO_EARLY:
            return None
        if where is Whereabouts.NEVER_ARRIVED or self._was_just_written:
            return self._send_again()
        return await self._conclude_lost(why)

    async def _conclude_lost(self, why: str) -> Outcome | Move:
        if self._may_give_up:
            return self._gave_up(f'{why}: its goal may have run')
        return await self._decide(why)

    @property
    def _was_just_written(self) -> bool:
        """True if this life of the mission has written the intent, and asks the server before it sends
        anything.
        """
        return self._step.must_probe and self._step.history.intent is not self._intent

    def _send_again(self) -> Outcome | Move:
        """Send a goal that has never run, unless it was refused or the mission does not want it any more."""
        self._step.must_probe = False
        if self._interruption is not None:
            return Outcome(error=self._interruption.error)
        if self._refusal is not None:
            return Outcome(error=self._refusal)
        if self._step.measure_left() == 0.0:
            return Outcome(error=DeadlineError(f'{self._step.title}: its time is over, and it never began'))
        # A client refuses to send an id twice, as a protection against mistakes: so sending again needs a new
        # client.
        self._client = self._step.clients.renew_action(self._request.action_type, self._request.name)
        return Move.SEND

    async def _decide(self, why: str) -> Outcome | Move:
        """Let the mission or a person decide, since it is unknown whether the goal has run."""
        self._step.lift_limit()  # a person's answer may take longer
        goal_id = self._goal_id.hex()
        evidence = f'goal {goal_id} may have run, wholly or in part: {why}'
        decision = await self._step.decide_lost(self._request.if_lost, self._request.goal, evidence)
        if decision is Decision.DONE:
            return self._conclude_done()
        if decision is Decision.FAIL:
            return Outcome(error=StepLost(f'{self._step.title}: {evidence}'))
        self._attempt += 1
        self._interruption = self._refusal = None
        self._may_be_known = False
        try:
            await self._wait_for_server()
        except NoServerError as error:
            return Outcome(error=error)
        await self._write_intent()
        return Move.SEND
