"""Gives missions their turns: one at a time has the robot, and the most important of the others is next."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from goalwire.rules.missions.entries import Entry, EntryKind

if TYPE_CHECKING:
    from goalwire.missions.mission_run import MissionRun

_PRIORITY = 'priority'


def priority_entry(priority: int) -> Entry:
    """Return the entry that keeps a mission's priority."""
    return Entry(EntryKind.NOTE, -1, {'text': f'priority {priority}', _PRIORITY: priority})


def priority_of(entries: list[Entry]) -> int:
    """Return a mission's priority; 0 without an entry."""
    found = next((entry.body[_PRIORITY] for entry in entries if _PRIORITY in entry.body), 0)
    return int(str(found))


class Turns:
    """A queue of missions. A mission keeps its turn until it ends, also while it waits for a person.

    The next mission is that of the highest priority; of equal priorities, the one that was started first. A
    mission that began under an earlier runner comes before those that did not.
    """

    def __init__(self) -> None:
        self._waiting: list[MissionRun] = []
        self._more = asyncio.Event()
        self._task = asyncio.ensure_future(self._give())

    def add(self, run: MissionRun) -> None:
        """Let a mission wait for its turn."""
        self._waiting.append(run)
        self._more.set()

    async def _give(self) -> None:
        while True:
            self._more.clear()
            while self._waiting:
                run = min(self._waiting, key=_rank)
                self._waiting.remove(run)
                run.give_turn()
                await run.ended.wait()
            await self._more.wait()

    async def close(self) -> None:
        """Give no further turn. Idempotent."""
        self._task.cancel()
        await asyncio.wait([self._task])


def _rank(run: MissionRun) -> tuple[bool, int, float]:
    had_begun = any(entry.kind is EntryKind.INTENT for entry in run.entries())
    return not had_begun, -priority_of(run.entries()), run.row.begun
