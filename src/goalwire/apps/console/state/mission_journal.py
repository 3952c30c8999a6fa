"""The missions of a journal, as the page shows them, and the answers that its users give.

The journal belongs to the missions' runner, which may be another process, or not be there. The console reads
it, and leaves commands in it, as `goalwire mission` does.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from goalwire.errors import MissionError
from goalwire.execution.asyncio.waiting import in_thread
from goalwire.missions.file_lock import has_runner
from goalwire.missions.journal_store import MissionRow, Store
from goalwire.missions.questions import ANSWERS, answer_body
from goalwire.missions.wakeup import wake_runner
from goalwire.records import record
from goalwire.rules.missions.entries import Entry, MissionState

if TYPE_CHECKING:
    from goalwire.apps.console.state.rights import Rights
    from goalwire.rules.missions.entries import Json

MOST_ENDED = 30
"""The most missions that are shown besides the open ones."""

COMMANDS = {
    MissionState.LOST: tuple(ANSWERS['decide']),
    MissionState.APPROVAL: ANSWERS['approve'],
    MissionState.HELD: ('resume', 'undo', 'cancel'),
    MissionState.PAUSED: ('resume', 'undo', 'cancel'),
    MissionState.STUCK: ('resume', 'cancel'),
}
"""The commands that a person can give to a mission that waits, by its state. `undo` cancels the mission and
runs its undo steps, which may move the robot; `cancel` runs none of them.
"""


@record
class SeenMission:
    """A mission and its journal."""

    row: MissionRow
    entries: tuple[Entry, ...]


class MissionJournal:
    """One journal file, for all pages."""

    def __init__(self, path: str) -> None:
        self.path = Path(path)
        self._lock = asyncio.Lock()
        self.has_runner = True
        """Whether a runner had the journal at the last look. Without one, open missions stand still."""
        self._ended: dict[str, SeenMission] = {}
        """Missions that have ended, which no longer change."""

    async def look(self) -> list[SeenMission]:
        """Return the open missions and the latest that have ended, the newest last. Raises JournalError."""
        async with self._lock:
            return await in_thread(self._look)

    def _look(self) -> list[SeenMission]:
        self.has_runner = has_runner(self.path)
        with Store(self.path, must_exist=True) as store:
            rows = store.missions()
            ended = [row for row in rows if not row.state.is_open]
            shown = {row.id for row in rows if row.state.is_open} | {row.id for row in ended[-MOST_ENDED:]}
            self._ended = {id_: seen for id_, seen in self._ended.items() if id_ in shown}
            return [self._look_at(store, row) for row in rows if row.id in shown]

    def _look_at(self, store: Store, row: MissionRow) -> SeenMission:
        if row.id not in self._ended:
            seen = SeenMission(row, tuple(store.entries(row.id)))
            if row.state.is_open:
                return seen
            self._ended[row.id] = seen
        return self._ended[row.id]

    async def say(self, seen: MissionRow, word: str, by: Rights) -> None:
        """Answer a mission's question, or resume or cancel it. `seen` is the mission as the user saw it.

        Raises NotAllowedError if the console or its visitor may not send this to the mission, MissionError if
        the mission no longer waits for this answer or command, JournalError.
        """
        async with self._lock:
            verb, body = await in_thread(lambda: self._find_command(seen, word))
            by.check_to_command(seen.name, seen.id, verb, word)
            if by.who:
                body['who'] = by.who
            await in_thread(lambda: self._leave(seen.id, verb, body))

    def _find_command(self, seen: MissionRow, word: str) -> tuple[str, dict[str, Json]]:
        """Return the verb and the body of the command that the button `word` gives."""
        with Store(self.path, must_exist=True) as store:
            row = store.mission(seen.id)
            is_as_seen = row is not None and (row.state, row.changed) == (seen.state, seen.changed)
            if not is_as_seen or word not in COMMANDS.get(seen.state, ()):
                raise MissionError(f"mission '{seen.id}' does not wait for that any more")
            if word in {'undo', 'cancel'}:
                return 'cancel', {'undo': word == 'undo'}
            if word == 'resume':
                return 'resume', {}
            verb = 'decide' if seen.state is MissionState.LOST else 'approve'
            return verb, answer_body(verb, word, seen.state, store.entries(seen.id))

    def _leave(self, mission: str, verb: str, body: dict[str, Json]) -> None:
        with Store(self.path, must_exist=True) as store:
            store.command(mission, verb, body)
            wake_runner(store)
