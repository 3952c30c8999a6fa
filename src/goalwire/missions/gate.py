"""The gate before each new step: the mission may go on, or waits for its turn or for a person."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from goalwire.rules.missions.entries import Entry, EntryKind, MissionState

if TYPE_CHECKING:
    from goalwire.missions.mission_run_contract import RunningMission


class Gate:
    """A gate that is closed until the mission's turn, and while the mission is paused or held. A stopped
    mission passes the gate.
    """

    def __init__(self, run: RunningMission, held: str, *, must_check: bool, has_turn: bool) -> None:
        """`held` says why the mission waits for a person. `must_check`: call `resume_check` first.

        Without a turn the mission waits until `give_turn` is called.
        """
        self._has_turn = has_turn
        self._run = run
        self._held = held
        self._check = run.definition.resume_check if must_check else None
        notes = (entry.body['paused'] for entry in reversed(run.entries()) if 'paused' in entry.body)
        self.is_paused = bool(next(notes, False))
        self._opened = asyncio.Event()

    def open(self) -> None:
        """Let the mission go on, since a person allows it; a pending `resume_check` is still called."""
        self._held, self.is_paused = '', False
        self.wake()

    def give_turn(self) -> None:
        """Let the mission begin: no other mission has the robot."""
        self._has_turn = True
        self.wake()

    def wake(self) -> None:
        """Let the gate check its state again."""
        self._opened.set()

    async def wait(self) -> None:
        """Wait until the mission may go on, or must stop."""
        while self._run.stop is None:
            if not self._has_turn:
                await self._wait(MissionState.QUEUED, 'another mission has its turn')
            elif self._held:
                await self._wait(MissionState.HELD, self._held)
            elif self.is_paused:
                await self._wait(MissionState.PAUSED, 'somebody paused it')
            elif self._check is not None:
                await self._ask_world()
            else:
                return

    async def _wait(self, state: MissionState, why: str) -> None:
        run = self._run
        self._opened.clear()
        if run.state is not state:
            await run.write(Entry(EntryKind.NOTE, -1, {'text': f'{state}: {why}'}), state=state, why=why)
        await self._opened.wait()
        if run.stop is None:
            await run.write(state=MissionState.RUNNING)

    async def _ask_world(self) -> None:
        assert self._check is not None
        try:
            answer = await self._check(self._run.node)
        except Exception as error:
            answer = f'{type(error).__name__}: {error}'
        if answer is True:
            self._check = None
        else:
            self._held = f'resume_check says no{f": {answer}" if answer else ""}'
