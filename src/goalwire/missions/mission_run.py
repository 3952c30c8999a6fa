"""One mission in its runner: its code, its journal, and the commands of people."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import TYPE_CHECKING, Any

from goalwire.errors import JournalError, MissionFailed, MissionStopped, StepFailed
from goalwire.missions.gate import Gate
from goalwire.missions.journal_store import Change, MissionRow
from goalwire.missions.live_step import LiveStep
from goalwire.missions.mission_code import run_code
from goalwire.missions.outcomes import Outcome, make_end_entry
from goalwire.missions.questions import is_asking
from goalwire.missions.steps import Perform
from goalwire.records import replace
from goalwire.rules.missions.entries import Entry, EntryKind, Json, MissionState, goal_id_of
from goalwire.rules.missions.replay import StepHistory

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import goalwire
    from goalwire.missions.clients import Clients
    from goalwire.missions.definition import Definition
    from goalwire.missions.journal_store import Command
    from goalwire.missions.journal_writer import Writer
    from goalwire.missions.this_computer import ThisComputer

Boundary = Callable[[str, str], None]
"""A function of the test kit. It is called at each place where a crash can be tested, with the place's name
('before write', 'after send', …) and the step."""


class _JournalIsBroken(BaseException):
    """Ends a mission's code, even if the code catches Exception: a later step would not be in the journal."""


class MissionRun:
    """A mission that this runner carries out. `begin` it, and `close` it with the runner."""

    def __init__(
        self,
        row: MissionRow,
        definition: Definition,
        entries: Sequence[Entry],
        writer: Writer,
        clients: Clients,
        node: goalwire.Node,
        computer: ThisComputer,
        boundary: Boundary,
        *,
        held: str = '',
        was_restarted: bool = False,
        is_suspicious: bool = False,
        has_turn: bool = True,
    ) -> None:
        """`held` is the reason why the mission waits for a person. `was_restarted`: another runner began it.

        `is_suspicious`: the machine was restarted, so the disk may have lost the last commit. Without a turn
        no step begins before `give_turn`.
        """
        self.row = row
        self.definition = definition
        self.clients = clients
        self.node = node
        self.computer = computer
        self._boundary = boundary
        self.stop_requested = asyncio.Event()
        self.ended = asyncio.Event()
        self._changed = asyncio.Event()
        self.state = row.state
        self.why = row.why
        self.result: Any = row.result
        self.failure: JournalError | None = None
        """The error after which the journal cannot be written any more."""
        self._writer = writer
        self._entries = list(entries)
        self._gate = Gate(self, held, must_check=was_restarted, has_turn=has_turn)
        self.give_turn = self._gate.give_turn
        self._is_suspicious = is_suspicious
        self._answer: tuple[int, asyncio.Future[str]] | None = None
        self._task: asyncio.Task[None] | None = None
        self._alarm: asyncio.TimerHandle | None = None
        self._stopping: asyncio.Future[None] | None = None
        self.stop: Entry | None = next((each for each in entries if each.kind is EntryKind.STOP), None)
        """The entry with the reason why the mission must stop; None if it need not."""
        if self.stop is not None:
            self.stop_requested.set()

    def boundary(self, name: str, step: str) -> None:
        """Report a place in the code to the test kit, which may let the program crash there."""
        self._boundary(name, step)

    def entries(self) -> list[Entry]:
        """Return the mission's journal."""
        return self._entries

    def entries_of(self, step: int) -> tuple[Entry, ...]:
        """Return the journal's entries of one step."""
        return tuple(entry for entry in self._entries if entry.step == step)

    # -- its life ------------------------------------------------------------------------------------------

    def begin(self) -> None:
        """Start the mission's code. Steps that have ended take their outcomes from the journal."""
        if not self.state.is_open:
            self.ended.set()
            return
        if self.definition.timeout is not None:
            left = self.row.begun + self.definition.timeout - self.computer.wall()
            self._alarm = asyncio.get_running_loop().call_later(max(left, 0.0), self._on_time)
        self._task = asyncio.ensure_future(self._main())

    async def close(self) -> None:
        """Stop the code at its current step; the mission goes on with the next runner. Idempotent."""
        if self._alarm is not None:
            self._alarm.cancel()
        if self._task is not None:
            self._task.cancel()
            await asyncio.wait([self._task])

    async def _main(self) -> None:
        try:
            change = await run_code(self, self)
            await self._write(change)
        except _JournalIsBroken as broken:
            self.failure = broken.__cause__ if isinstance(broken.__cause__, JournalError) else None
            self.why = str(self.failure)
            self._changed.set()
            self.node.logger.error(f'Mission {self.row.id}: no further step begins: {self.failure}')
            self.ended.set()
            return
        if self._alarm is not None and not self.state.is_open:
            self._alarm.cancel()
        if not self.state.is_open:
            self.ended.set()
            self._changed.set()

    def _on_time(self) -> None:
        if self.stop is None and self.state.is_open:
            text = f'its time of {self.definition.timeout} s is over'
            self._stopping = asyncio.ensure_future(
                self._request_stop({'by': 'timeout', 'why': text, 'undo': True})
            )

    # -- writing -------------------------------------------------------------------------------------------

    async def write(self, *entries: Entry, state: MissionState | None = None, why: str = '') -> None:
        """Write entries and the mission's new state to the disk; if that fails, its code is ended."""
        if state is None and self.state is not MissionState.RUNNING:
            state = MissionState.RUNNING
        await self._write(Change(self.row.id, entries, state, why))

    async def _write(self, change: Change) -> None:
        title = ', '.join(f'{entry.kind} of step {entry.step + 1}' for entry in change.entries) or 'state'
        now = self.computer.wall()
        change = replace(change, entries=tuple(replace(each, at=now) for each in change.entries))
        self.boundary('before write', title)
        try:
            await self._writer.write(change)
        except JournalError as error:
            raise _JournalIsBroken from error
        self._entries.extend(change.entries)
        if change.state is not None:
            self.state, self.why, self.result = change.state, change.why, change.result
        self._changed.set()
        self._changed = asyncio.Event()
        self.boundary('after write', title)

    async def tell(self, why: str) -> None:
        """Show why the mission cannot go on."""
        if why != self.why:
            await self.write(state=MissionState.RUNNING, why=why)

    # -- steps ---------------------------------------------------------------------------------------------

    async def perform(
        self, history: StepHistory, how: Perform, *, is_undoing: bool, always_begins: bool
    ) -> Outcome:
        """Carry out a step that has not ended, and write its outcome."""
        await self._gate.wait()
        if self.stop is not None and history.intent is None and not (is_undoing or always_begins):
            outcome = Outcome(error=self.make_stop_error())
        else:
            outcome = await how(LiveStep(self, history, is_undoing=is_undoing))
        try:
            entry = make_end_entry(history.number, history.key, outcome)
        except (TypeError, ValueError) as error:
            outcome = Outcome(error=StepFailed(f'its value cannot be kept: {error}'))
            entry = make_end_entry(history.number, history.key, outcome)
        await self.write(entry)
        return outcome

    def take_suspicion(self) -> bool:
        """Return True for the first step after a reboot, since the disk may have lost a commit."""
        was_suspicious, self._is_suspicious = self._is_suspicious, False
        return was_suspicious

    def goal_id(self, step: int, attempt: int) -> bytes:
        """Return the id of a step's goal. It is the same in every life of the mission."""
        return goal_id_of(self._writer.store.uuid, self.row.id, step, attempt).bytes

    def make_stop_error(self) -> MissionStopped:
        """Return the error that stops the mission's code."""
        assert self.stop is not None
        return MissionStopped(str(self.stop.body['why']), undo=bool(self.stop.body['undo']))

    # -- people --------------------------------------------------------------------------------------------

    def expect_answer(self, step: int) -> asyncio.Future[str]:
        """Return a future for a person's answer to a step's question."""
        future: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._answer = step, future
        return future

    def expect_no_answer(self) -> None:
        """Note that no question is open any more."""
        self._answer = None

    async def take(self, command: Command) -> None:
        """Carry out a person's command; one that came too late does nothing. Raises JournalError."""
        try:
            await self._carry_out(command)
        except _JournalIsBroken as broken:
            raise JournalError(str(broken.__cause__)) from broken

    async def _carry_out(self, command: Command) -> None:
        match command.verb:
            case 'pause' | 'resume':
                await self._take_pause(_who(command), is_paused=command.verb == 'pause')
            case 'cancel' if self.stop is None and self.state.is_open:
                body: dict[str, Json] = {
                    'by': 'cancel',
                    'why': f'{_who(command) or "somebody"} cancelled it',
                    'undo': bool(command.body.get('undo', True)),
                }
                await self._request_stop(body)
            case 'decide' | 'approve':
                await self._take_answer(command.body)

    async def _take_pause(self, who: str, *, is_paused: bool) -> None:
        if self.state is MissionState.STUCK and not is_paused:
            await self._replay_again()
            return
        if not self.state.is_open:
            return
        text = ('paused' if is_paused else 'resumed') + (f' by {who}' if who else '')
        note: dict[str, Json] = {'text': text, 'paused': is_paused}
        entry = Entry(EntryKind.NOTE, -1, note)
        waits = self.state.waits_for_somebody
        state = MissionState.PAUSED if is_paused and not waits else None
        why = f'{who or "somebody"} paused it' if state else ''
        await self._write(Change(self.row.id, (entry,), state, why))
        if is_paused:
            self._gate.is_paused = True
            return
        self._gate.open()
        if self.state is MissionState.PAUSED:
            await self._write(Change(self.row.id, (), MissionState.RUNNING))

    async def _replay_again(self) -> None:
        """Run the mission's code again, after it did not fit the journal."""
        await self._write(Change(self.row.id, (), MissionState.RUNNING))
        self._task = asyncio.ensure_future(self._main())

    async def _request_stop(self, body: Mapping[str, Json]) -> None:
        entry = Entry(EntryKind.STOP, -1, body)
        await self._write(Change(self.row.id, (entry,)))
        self.stop = entry
        self.stop_requested.set()
        self._gate.wake()
        if self.state is MissionState.STUCK:
            change = Change(
                self.row.id, (), MissionState.CANCELED, f'{body["why"]} while it was stuck: nothing is undone'
            )
            await self._write(change)
            self.ended.set()

    async def _take_answer(self, body: Mapping[str, Json]) -> None:
        """Write the first answer to an open question. A later one does nothing."""
        number = body.get('step')
        if not isinstance(number, int) or not is_asking(self.entries_of(number)):
            return
        answer = str(body['answer'])
        told = {key: body[key] for key in ('answer', 'who') if key in body}
        await self._write(Change(self.row.id, (Entry(EntryKind.ANSWERED, number, told),)))
        if self._answer is not None and self._answer[0] == number and not self._answer[1].done():
            self._answer[1].set_result(answer)

    # -- its end -------------------------------------------------------------------------------------------

    async def until(self, *states: MissionState) -> MissionState:
        """Wait until the mission is in one of these states, or has ended; return its state.

        Raises JournalError if it never will be, since the journal cannot be written any more.
        """
        while self.state not in states and not self.ended.is_set():
            await self._changed.wait()
        if self.failure is not None and self.state not in states:
            raise self.failure
        return self.state

    async def journal(self) -> AsyncIterator[Entry]:
        """Yield the entries of the journal, also later ones, until the mission has ended."""
        number = 0
        while True:
            while number < len(self._entries):
                yield self._entries[number]
                number += 1
            if self.ended.is_set():
                return
            await self._changed.wait()

    async def wait(self) -> Any:
        """Wait for the end of the mission and return its value. Raises MissionFailed, JournalError."""
        await self.ended.wait()
        if self.failure is not None:
            raise self.failure
        if self.state is MissionState.SUCCEEDED:
            return self.result
        raise MissionFailed(f'mission {self.row.id} {self.state}: {self.why}')


def _who(command: Command) -> str:
    """Return the name of the person who gave a command; '' if the command has no name."""
    return str(command.body.get('who', ''))
