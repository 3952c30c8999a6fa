"""Crash tests for durable missions: a mission runs once for each place where its runner may die.

The runner dies before and after each write to its journal, and before and after each send. Then another
runner continues with the same file. The mission's servers count the goals that they get, so a step that
happened twice is noticed.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from goalwire.missions.runner import Runner
from goalwire.records import record

if TYPE_CHECKING:
    import goalwire
    from goalwire.missions.definition import Definition
    from goalwire.missions.mission_run import MissionRun
    from goalwire.rules.missions.entries import MissionState

Between = Callable[[], Awaitable[object]]
"""Awaited after a crash, before the next runner: the function may restart a server, or let results expire."""
MakeNode = Callable[[], AbstractAsyncContextManager['goalwire.Node']]
MakeWorld = Callable[[], AbstractAsyncContextManager[object]]
"""Entered before each run and left after it: the servers of one run."""
Chosen = Callable[[str], bool]
"""Returns True for the boundaries to crash at."""


class _Crash(BaseException):
    """Ends a runner at a boundary, so that no code after the boundary runs."""


@record
class CrashRun:
    """One run of a mission whose runner died once."""

    mission: str
    """The id of the mission."""
    boundary: str
    """The boundary where its runner died, such as 'after write, intent of step 1'; '' if it did not die."""
    state: MissionState
    """The mission's last state: succeeded, or the state in which it waits for a person."""
    why: str
    result: Any
    sends: tuple[str, ...]
    """The steps that were sent to a server, in order; a step that occurs twice was sent twice."""

    @property
    def asks(self) -> bool:
        """True if the mission waits for a person."""
        return self.state.waits_for_somebody


class _Life:
    """One life of a runner: from its start until the mission ends or asks a person, or until the simulated
    crash.
    """

    def __init__(self, sends: list[str], crash_at: int | None) -> None:
        self.boundaries: list[str] = []
        self.run: MissionRun | None = None
        self._sends = sends
        self._crash_at = crash_at
        self._over = asyncio.Event()
        self.has_crashed = False

    def pass_boundary(self, name: str, step: str) -> None:
        """Raise a crash at the chosen boundary."""
        if self.has_crashed:
            raise _Crash
        if name == 'after send':
            self._sends.append(step)
        self.boundaries.append(f'{name}, {step}')
        if len(self.boundaries) - 1 == self._crash_at:
            self.has_crashed = True
            self._over.set()
            raise _Crash
        if self.run is not None and self.run.state.waits_for_somebody:
            self._over.set()

    async def last(self, run: MissionRun) -> None:
        """Wait until the mission ends or asks a person, or until the simulated crash."""
        self.run = run
        if run.state.waits_for_somebody:
            return
        waits = [asyncio.ensure_future(each.wait()) for each in (run.ended, self._over)]
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        for each in waits:
            each.cancel()


async def crash_everywhere(
    mission: Definition,
    *arguments: Any,
    make_node: MakeNode,
    folder: Path,
    between: Between | None = None,
    make_world: MakeWorld = nullcontext,
    chosen: Chosen = bool,
) -> list[CrashRun]:
    """Run a mission once without a crash, then once for each boundary, and return how each run ended.

    Each run has its own file in `folder`, and `make_node()` gives the node of each runner. The mission's
    servers belong to the test and stay alive, unless `between()` changes that: it is awaited after each
    crash, before the next runner. Servers that must be new in each run start in `make_world()`. With `chosen`
    only those boundaries are tried for whose name it returns True. In virtual time (`gw_clock`) this takes no
    real time.
    """
    play = partial(_run, mission, arguments, make_node, between)
    async with make_world():
        undisturbed, boundaries = await play(folder / 'run.db', None)
    runs = [undisturbed]
    for number, boundary in enumerate(boundaries):
        if chosen(boundary):
            async with make_world():
                run, _ = await play(folder / f'crash-{number}.db', number)
            runs.append(run)
    return runs


async def _run(
    mission: Definition,
    arguments: tuple[Any, ...],
    make_node: MakeNode,
    between: Between | None,
    path: Path,
    crash_at: int | None,
) -> tuple[CrashRun, list[str]]:
    sends: list[str] = []
    crashed_at = ''
    while True:
        life = _Life(sends, crash_at)
        async with (
            make_node() as node,
            Runner(node, path, missions=[mission], boundary=life.pass_boundary) as runner,
        ):
            run = await runner.start(mission, *arguments, id=path.stem)
            await life.last(run)
        if not life.has_crashed:
            made = CrashRun(path.stem, crashed_at, run.state, run.why, run.result, tuple(sends))
            return made, life.boundaries
        crashed_at, crash_at = life.boundaries[-1], None
        if between is not None:
            await between()
