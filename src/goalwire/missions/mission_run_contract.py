"""The interface of a running mission for its steps, its gate and its code. MissionRun implements it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import goalwire
    from goalwire.errors import MissionStopped
    from goalwire.missions.clients import Clients
    from goalwire.missions.definition import Definition
    from goalwire.missions.journal_store import MissionRow
    from goalwire.missions.this_computer import ThisComputer
    from goalwire.rules.missions.entries import Entry, MissionState


class RunningMission(Protocol):
    """A running mission."""

    row: MissionRow
    definition: Definition
    node: goalwire.Node
    clients: Clients
    computer: ThisComputer
    state: MissionState
    stop: Entry | None
    """The entry with the reason why the mission must stop; None if it need not."""
    stop_requested: asyncio.Event

    def entries(self) -> list[Entry]: ...

    def entries_of(self, step: int) -> tuple[Entry, ...]: ...

    async def write(self, *entries: Entry, state: MissionState | None = None, why: str = '') -> None: ...

    async def tell(self, why: str) -> None: ...

    def boundary(self, name: str, step: str, /) -> object: ...

    def take_suspicion(self) -> bool: ...

    def goal_id(self, step: int, attempt: int) -> bytes: ...

    def make_stop_error(self) -> MissionStopped: ...

    def expect_answer(self, step: int) -> asyncio.Future[str]: ...

    def expect_no_answer(self) -> None: ...
