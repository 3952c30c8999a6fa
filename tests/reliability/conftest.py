"""Two nodes with faults between them, and the evidence of each test for docs/reference/reliability.md.

Each test says what it has shown by `evidence(item, …)`; GOALWIRE_EVIDENCE names the file that collects it.
"""

from __future__ import annotations

import json
import os
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import NamedTuple, TypeAlias

import pytest
from helpers.isolation import isolated_env, lease_variables
from helpers.outcomes import Outcomes
from helpers.pending import left_pending
from helpers.processes import Program
from helpers.programs import Start, programs_in, server_of_programs
from helpers.wires import DDS, require

import goalwire
from goalwire.entities.context import Context
from goalwire.transport.faults import Faults

WIRES = {'goalwire_memory': 'memory', 'rmw_zenoh_cpp': 'Zenoh', DDS: 'DDS'}
BETWEEN_PROCESSES = pytest.mark.parametrize(
    'transport_name', [wire for wire in WIRES if wire != 'goalwire_memory'], indirect=True
)
"""Marks what is about processes, which the memory wire does not connect."""

PROGRAMS = Path(__file__).parent / 'programs'
LEASE_S = 1.0
"""Of every link in an `impatient_world`."""

EVIDENCE = os.environ.get('GOALWIRE_EVIDENCE')
"""Read here: a test's world hides it."""

LONG_ONES = EVIDENCE is not None
WHERE_LONG = 'takes long: `make reliability` alone'
LONG = pytest.mark.skipif(not LONG_ONES, reason=WHERE_LONG)

Evidence: TypeAlias = Callable[[int, str, Outcomes], None]
"""Notes what a test has shown of an item of the list: under which faults, and how things ended."""


@pytest.fixture(params=[*WIRES])
def transport_name(request: pytest.FixtureRequest) -> str:
    """All three wires."""
    name: str = request.param
    require(name)
    return name


@pytest.fixture
def start(transport_name: str) -> Iterator[Start]:
    """A function that starts a program of this folder, in a world where peers are missed soon."""
    with programs_in(impatient_world(transport_name), PROGRAMS, server_of_programs()) as start:
        yield start


@pytest.fixture
def evidence(request: pytest.FixtureRequest) -> Iterator[Evidence]:
    """Collects a test's rows. They are written once it has passed."""
    rows: list[dict[str, object]] = []
    parameters = getattr(request.node, 'callspec', None)
    wire = WIRES[parameters.params.get('transport_name', DDS)] if parameters else 'all'

    def note(item: int, faults: str, outcomes: Outcomes) -> None:
        rows.append(
            {
                'item': item,
                'wire': wire,
                'faults': faults,
                'outcomes': dict(outcomes.counts),
                'slowest': outcomes.slowest,
            }
        )

    yield note
    if EVIDENCE is not None:
        with Path(EVIDENCE).open('a', encoding='utf-8') as lines:
            lines.writelines(json.dumps(row) + '\n' for row in rows)


def impatient_world(wire: str, lease_s: float = LEASE_S) -> dict[str, str]:
    """Return an environment for programs that soon miss a peer."""
    return isolated_env(wire) | lease_variables(lease_s)


def told(mission: Program, outcomes: Outcomes, since: float | None = None) -> str:
    """Wait for the end of what programs/mission.py does, and count it; an error with its time.

    That is the time since a fault struck where `since` (s) tells, else since the call began.
    """
    kind, at, took = mission.expect(r'^ended (\w+) (\d+) ([\d.e-]+)$').groups()
    seconds = float(took) if since is None else int(at) / 1e9 - since
    outcomes.note(kind, None if kind == 'done' else seconds)
    return kind


class Stage(NamedTuple):
    """A server's node and a client's node, each in a session of its own, and the faults between them."""

    arm: goalwire.Node
    mission: goalwire.Node
    faults: Faults


MakeStage: TypeAlias = Callable[[], AbstractAsyncContextManager[Stage]]


@pytest.fixture
def stage(isolated: dict[str, str]) -> MakeStage:
    """`async with stage()`: when it ends nothing of the client's may wait for anything."""

    @asynccontextmanager
    async def make() -> AsyncIterator[Stage]:
        plan = Faults(seed=7)
        contexts = Context(), Context()
        with plan:
            for context in contexts:
                context.init([])
            try:
                async with (
                    goalwire.Node('arm', context=contexts[0]) as arm,
                    goalwire.Node('mission', context=contexts[1]) as mission,
                ):
                    yield Stage(arm, mission, plan)
                    assert left_pending(mission._open_core()) == {}
            finally:
                plan.heal()
                for context in contexts:
                    context.try_shutdown()

    return make
