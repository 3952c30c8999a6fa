"""Runs missions, and continues those that an earlier runner of the same file has left."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from contextlib import AsyncExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

from goalwire.errors import ClosedError, JournalError, MissionError, MissionIdTaken
from goalwire.missions.clients import Clients
from goalwire.missions.file_lock import FileLock, lock_path
from goalwire.missions.journal_store import Change, Command, MissionRow, Store, as_json
from goalwire.missions.journal_writer import Writer
from goalwire.missions.mission_run import Boundary, MissionRun
from goalwire.missions.questions import answer_body
from goalwire.missions.schedule import Missed, Slots, keep_schedule, slot_id
from goalwire.missions.this_computer import ThisComputer
from goalwire.missions.turns import Turns, priority_entry
from goalwire.missions.wakeup import hang_bell, note_port
from goalwire.rules.missions.entries import Entry, Json, MissionState
from goalwire.rules.missions.holding import Sighting, why_held

if TYPE_CHECKING:
    from types import TracebackType

    import goalwire
    from goalwire.missions.definition import Definition

_ALIVE_S = 15.0
"""The seconds between two signs of life of a runner with open missions. These are not flushed to the disk."""


class Runner:
    """The runner of a file's missions: `async with Runner(node, 'missions.db', missions=[fetch]) as runner:`.

    On entering the block the open missions of the file go on, if their code is in `missions`. Leaving the
    block ends no mission and cancels no goal: the next runner goes on.
    """

    def __init__(
        self,
        node: goalwire.Node,
        path: str | Path,
        *,
        missions: Iterable[Definition] = (),
        one_at_a_time: bool = False,
        computer: ThisComputer | None = None,
        boundary: Boundary | None = None,
    ) -> None:
        """`missions` are the functions whose missions this runner continues. `start` adds others. With
        `one_at_a_time` each mission waits until no other one has the robot.

        `computer` and `boundary` are for the test kit: other clocks, and places to crash at.
        """
        self._node = node
        self._path = Path(path)
        self._definitions = {each.name: each for each in missions}
        self._computer = computer or ThisComputer()
        self._boundary: Boundary = boundary or (lambda _name, _step: None)
        self._runs: dict[str, MissionRun] = {}
        self._resources = AsyncExitStack()
        self._writer: Writer | None = None
        self._commands: asyncio.Task[None] | None = None
        self._one_at_a_time = one_at_a_time
        self._turns: Turns | None = None
        self._schedules: list[asyncio.Task[None]] = []
        self._rung = asyncio.Event()
        self._alive: asyncio.TimerHandle | None = None

    # -- its life ------------------------------------------------------------------------------------------

    async def __aenter__(self) -> Self:
        """Open the journal and continue its open missions. Raises JournalError."""
        async with AsyncExitStack() as stack:
            lock = FileLock(lock_path(self._path))
            stack.callback(lock.close)
            store = Store(self._path)
            writer = Writer(store, self._computer)
            stack.push_async_callback(writer.close)
            bell, port = await hang_bell(self._rung.set)
            stack.callback(bell.close)
            await writer.run(lambda: note_port(store, port))
            self._writer = writer
            self.clients = Clients(self._node, self._computer)  # its missions share them
            stack.push_async_callback(self.clients.close)
            self._lock = lock
            if self._one_at_a_time:
                self._turns = Turns()
                stack.push_async_callback(self._turns.close)
            last = lock.read_last_seen()
            for row in await writer.run(store.missions):
                if row.state.is_open:
                    await self._take_up(row, last)
            self._note_alive()
            self._rung.set()  # commands may have been given while no runner was there
            self._commands = asyncio.ensure_future(self._take_commands())
            stack.push_async_callback(self._end)
            self._resources = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._resources.aclose()

    async def _end(self) -> None:
        self._writer = None  # from now on no mission begins
        if self._alive is not None:
            self._alive.cancel()
        assert self._commands is not None
        under_way = [self._commands, *self._schedules]
        for task in under_way:
            task.cancel()
        await asyncio.wait(under_way)
        for run in self._runs.values():
            await run.close()
        self._lock.note(self._computer.sighting())

    def _note_alive(self) -> None:
        """Record a sign of life in the lock's file, again and again while missions are open."""
        self._lock.note(self._computer.sighting())
        if any(run.state.is_open for run in self._runs.values()):
            self._alive = asyncio.get_running_loop().call_later(_ALIVE_S, self._note_alive)
        else:
            self._alive = None

    async def _take_up(self, row: MissionRow, last: Sighting | None) -> None:
        """Continue a mission of an earlier runner."""
        writer = self._open_writer()
        definition = self._definitions.get(row.name)
        if definition is None:
            why = f"this runner does not have the mission '{row.name}': name it in Runner(missions=…)"
            await writer.write(Change(row.id, state=MissionState.STUCK, why=why))
            return
        entries = await writer.run(lambda: writer.store.entries(row.id))
        held = why_held(definition.resume, last, self._computer.sighting())
        if not held and row.state is MissionState.HELD:
            held = row.why
        is_suspicious = last is None or last.boot != self._computer.boot
        run = self._make_run(
            row, definition, entries, held=held, was_restarted=True, is_suspicious=is_suspicious
        )
        run.begin()

    def _make_run(
        self,
        row: MissionRow,
        definition: Definition,
        entries: list[Entry],
        *,
        held: str = '',
        was_restarted: bool = False,
        is_suspicious: bool = False,
    ) -> MissionRun:
        run = self._runs[row.id] = MissionRun(
            row,
            definition,
            entries,
            self._open_writer(),
            self.clients,
            self._node,
            self._computer,
            self._boundary,
            held=held,
            was_restarted=was_restarted,
            is_suspicious=is_suspicious,
            has_turn=self._turns is None,
        )
        if self._turns is not None:
            self._turns.add(run)
        return run

    def _open_writer(self) -> Writer:
        if self._writer is None:
            raise ClosedError('a runner works in its block: async with Runner(node, path) as runner:')
        return self._writer

    # -- missions ------------------------------------------------------------------------------------------

    async def start(
        self, definition: Definition, *arguments: Any, id: str | None = None, priority: int = 0
    ) -> MissionRun:
        """Begin a mission, or return the one that was begun with this `id` before.

        `arguments` are values that JSON can hold; the mission's function gets them after the steps `m`.
        Without an `id` the mission gets a new one. If one mission at a time runs, the next one is that of the
        highest `priority`; the one that runs is not interrupted. Raises MissionIdTaken if the id belongs to
        another mission, or to other arguments; JournalError; TypeError and ValueError for arguments that the
        journal cannot keep.
        """
        writer = self._open_writer()
        id_ = id or str(uuid4())
        self._definitions.setdefault(definition.name, definition)
        as_json(arguments)
        known = await writer.run(lambda: writer.store.mission(id_))
        if known is not None:
            if (known.name, list(known.arguments)) != (definition.name, list(arguments)):
                raise MissionIdTaken(
                    f"mission '{id_}' is {known.name}{known.arguments}, begun before: choose another id"
                )
            return await self._find_run(known, definition)
        now = self._computer.wall()
        row = MissionRow(
            id_,
            definition.name,
            definition.version,
            definition.fingerprint,
            tuple(arguments),
            MissionState.RUNNING if self._turns is None else MissionState.QUEUED,
            '',
            now,
            now,
        )
        entries = [priority_entry(priority)] if priority else []
        await writer.run(lambda: writer.store.add(row, *entries))
        run = self._make_run(row, definition, entries)
        run.begin()
        if self._alive is None:
            self._note_alive()
        return run

    async def schedule(
        self,
        definition: Definition,
        *arguments: Any,
        daily: str | None = None,
        every: float | None = None,
        missed: Missed = 'skip',
        name: str | None = None,
        priority: int = 0,
    ) -> None:
        """Start a mission `daily` at 'HH:MM' local time, or `every` so many seconds, at full multiples.

        Each slot is started once, also if the runner is restarted or the clock is set back. A slot for which
        no runner was there is skipped, or the latest one is made up for (`missed='run'`). `name` tells
        several schedules of one mission apart; the missions' ids are made of it and their slots. Call this
        in each life of the runner. Raises ValueError for wrong times, JournalError.
        """
        slots = Slots(daily, every)
        if missed not in {'skip', 'run'}:
            raise ValueError(f"missed is 'skip' or 'run', not {missed!r}")
        title = name or definition.name
        writer, now = self._open_writer(), self._computer.wall()
        since = await writer.run(lambda: writer.store.first_time(f'schedule {title}', now))
        start = partial(self._start_slot, definition, arguments, title, priority)
        keeping = keep_schedule(slots, since, missed, self._computer.wall, start)
        self._schedules.append(asyncio.ensure_future(keeping))

    async def _start_slot(
        self, definition: Definition, arguments: tuple[Any, ...], title: str, priority: int, slot: float
    ) -> None:
        try:
            await self.start(definition, *arguments, id=slot_id(title, slot), priority=priority)
        except (JournalError, MissionIdTaken) as error:
            self._node.logger.error(f"The schedule '{title}' has not started its mission: {error}")

    async def _find_run(self, row: MissionRow, definition: Definition) -> MissionRun:
        run = self._runs.get(row.id)
        if run is None:
            writer = self._open_writer()
            entries = await writer.run(lambda: writer.store.entries(row.id))
            run = self._make_run(row, definition, entries, was_restarted=True)
            run.begin()
        return run

    async def has(self, id_: str) -> bool:
        """Return whether a mission with this id was begun before, by this runner or an earlier one."""
        writer = self._open_writer()
        return await writer.run(lambda: writer.store.mission(id_)) is not None

    def missions(self) -> list[MissionRun]:
        """Return the missions that this runner has begun or continued."""
        return list(self._runs.values())

    async def serve(self) -> None:
        """Wait until the task is cancelled.

        Raises JournalError as soon as the journal cannot be written: only another runner can go on then.
        """
        raise await asyncio.shield(self._open_writer().failure)

    # -- people --------------------------------------------------------------------------------------------

    async def pause(self, id_: str) -> None:
        """Pause a mission: the step under way goes on, and no further step begins."""
        await self._command(id_, 'pause', {})

    async def resume(self, id_: str) -> None:
        """Let a paused or held mission go on, or run a stuck one again."""
        await self._command(id_, 'resume', {})

    async def cancel(self, id_: str, *, undo: bool = True) -> None:
        """Stop a mission: its goal under way is cancelled, and its undo steps run unless `undo` is false."""
        await self._command(id_, 'cancel', {'undo': undo})

    async def answer(self, id_: str, verb: str, answer: str) -> None:
        """Answer the question of a lost step ('decide') or of the mission ('approve').

        Raises MissionError if the mission asks no such question, or does not accept the answer.
        """
        run = self._runs.get(id_)
        if run is None:
            raise MissionError(f"this runner has no mission '{id_}'")
        await self._command(id_, verb, answer_body(verb, answer, run.state, run.entries()))

    async def _command(self, id_: str, verb: str, body: dict[str, Json]) -> None:
        writer = self._open_writer()
        if id_ not in self._runs:
            raise MissionError(f"this runner has no mission '{id_}'")
        await writer.run(lambda: writer.store.command(id_, verb, body))
        self._rung.set()

    async def _take_commands(self) -> None:
        """Carry out commands in their order. Each is removed after its effect is on the disk."""
        writer = self._open_writer()
        while True:
            await self._rung.wait()
            self._rung.clear()
            try:
                for command in await writer.run(writer.store.commands):
                    await self._take(command)
                    await writer.run(partial(writer.store.take_command, command.number))
            except JournalError as error:
                self._node.logger.error(f'Commands to missions are not carried out: {error}')

    async def _take(self, command: Command) -> None:
        run = self._runs.get(command.mission)
        if run is not None:
            await run.take(command)
        elif command.verb == 'cancel':  # without its code, a mission can only be cancelled
            change = Change(command.mission, state=MissionState.CANCELED, why='cancelled without its code')
            await self._open_writer().write(change)
