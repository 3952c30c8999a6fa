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
from goalwire.missions.questions import ANSWERS, answer_body
from goalwire.missions.store import MissionRow, Store
from goalwire.missions.wakeup import wake_runner
from goalwire.records import record
from goalwire.rules.missions.entries import Entry, MissionState

if TYPE_CHECKING:
    from goalwire.apps.console.settings import Settings

MOST_ENDED = 30
"""The most missions that are shown besides the open ones."""

COMMANDS = {
    MissionState.LOST: tuple(ANSWERS['decide']),
    MissionState.APPROVAL: ANSWERS['approve'],
    MissionState.HELD: ('resume', 'cancel'),
    MissionState.PAUSED: ('resume', 'cancel'),
    MissionState.STUCK: ('resume', 'cancel'),
}
"""What a person can say to a mission that waits."""


@record
class SeenMission:
    """A mission and its journal."""

    row: MissionRow
    entries: tuple[Entry, ...]


class MissionJournal:
    """One journal file, for all pages."""

    def __init__(self, path: str, settings: Settings) -> None:
        self.path = Path(path)
        self._settings = settings
        self._lock = asyncio.Lock()
        self._ended: dict[str, SeenMission] = {}
        """Missions that have ended, which no longer change."""

    async def look(self) -> list[SeenMission]:
        """Return the open missions and the latest that have ended, the newest last. Raises JournalError."""
        async with self._lock:
            return await in_thread(self._look)

    def _look(self) -> list[SeenMission]:
        with Store(self.path, must_exist=True) as store:
            rows = store.missions()
            ended = [row for row in rows if not row.state.is_open]
            shown = {row.id for row in rows if row.state.is_open} | {row.id for row in ended[-MOST_ENDED:]}
            self._ended = {id_: seen for id_, seen in self._ended.items() if id_ in shown}
            return [self._seen(store, row) for row in rows if row.id in shown]

    def _seen(self, store: Store, row: MissionRow) -> SeenMission:
        if row.id not in self._ended:
            seen = SeenMission(row, tuple(store.entries(row.id)))
            if row.state.is_open:
                return seen
            self._ended[row.id] = seen
        return self._ended[row.id]

    async def say(self, mission: str, word: str) -> None:
        """Answer a mission's question, or resume or cancel it.

        Raises NotAllowedError if the console may not send to the mission's name, MissionError if the mission
        no longer waits for this answer or command, JournalError.
        """
        async with self._lock:
            await in_thread(lambda: self._say(mission, word))

    def _say(self, mission: str, word: str) -> None:
        with Store(self.path, must_exist=True) as store:
            row = store.mission(mission)
            if row is None or word not in COMMANDS.get(row.state, ()):
                raise MissionError(f"mission '{mission}' does not wait for that any more")
            self._settings.check_may_send(row.name)
            verb = {MissionState.LOST: 'decide', MissionState.APPROVAL: 'approve'}.get(row.state, word)
            is_answer = verb in ANSWERS
            body = answer_body(verb, word, row.state, store.entries(mission)) if is_answer else {}
            store.command(mission, verb, body)
            wake_runner(store)
