"""A server with a journal is killed at every boundary of a goal, in processes of its own and on real wires.

Afterwards the next process knows how the goal stands, and the same id is never executed again.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from uuid import UUID

import pytest
from example_interfaces.action import Fibonacci
from helpers.loops import run
from helpers.programs import Start, programs_in
from helpers.wires import DDS, require

import goalwire
from goalwire import GoalState
from goalwire.errors import CallError

ID = UUID('6ba7b810-9dad-41d1-80b4-00c04fd430c8')
PATIENCE_S = 60.0

BOUNDARIES = {
    # where the server dies: how the next one says that the goal stands, and how often it has run by then
    'before its beginning is written': (GoalState.UNKNOWN, 0),
    'after its beginning is written': (GoalState.SERVER_DIED, 0),
    'after it is accepted': (GoalState.SERVER_DIED, 0),
    'executing': (GoalState.SERVER_DIED, 1),
    'before its end is written': (GoalState.SERVER_DIED, 1),
    'after its end is written': (GoalState.ENDED, 1),
    'after its result is sent': (GoalState.ENDED, 1),
}
LIKEWISE = set(BOUNDARIES) - {'after it is accepted', 'executing', 'before its end is written'}

CASES = [
    pytest.param(boundary, face, marks=[pytest.mark.long] if face == 'rclpy' and boundary in LIKEWISE else [])
    for boundary in BOUNDARIES
    for face in ('asyncio', 'rclpy')
]
"""Both faces share what is below them. Of rclpy's, each run has those where its callbacks are under way."""


@pytest.fixture(params=['rmw_zenoh_cpp', pytest.param(DDS, marks=pytest.mark.long)])
def transport_name(request: pytest.FixtureRequest) -> str:
    """Wires between processes."""
    name: str = request.param
    require(name)
    return name


@pytest.fixture
def start(isolated: dict[str, str]) -> Iterator[Start]:
    """A function that starts a program of this folder."""
    with programs_in(isolated, Path(__file__).parent / 'programs') as start:
        yield start


@pytest.mark.slow
@pytest.mark.parametrize(('boundary', 'face'), CASES)
def test_no_goal_runs_twice_wherever_its_server_dies(
    start: Start, tmp_path: Path, boundary: str, face: str
) -> None:
    state, executed = BOUNDARIES[boundary]
    executions = tmp_path / 'executions.txt'
    arguments = (tmp_path / 'job.goals', executions, face)

    def count() -> int:
        return len(executions.read_text(encoding='utf-8').splitlines()) if executions.exists() else 0

    async def send() -> bool:
        """Send the goal; True if it has reached its end."""
        async with goalwire.Node('client') as node:
            client = node.action(Fibonacci, 'job')
            await client.wait_for_server(timeout=PATIENCE_S)
            try:
                async with client.send(order=7, goal_id=ID, keep=True, timeout=PATIENCE_S) as sent:
                    return (await sent.result).sequence[0] == 7
            except CallError:
                return False

    async def probe() -> goalwire.GoalProbe[Fibonacci.Result]:
        async with goalwire.Node('prober') as node:
            client = node.action(Fibonacci, 'job')
            async with asyncio.timeout(PATIENCE_S):
                while True:  # a killed server stays in a DDS graph for its lease
                    found = await client.probe(ID)
                    if found.state is not GoalState.CANNOT_TELL:
                        return found

    first = start('dying_server', *arguments, boundary)
    first.expect('^ready$')
    run(send())
    first.wait()
    assert count() == executed
    start('dying_server', *arguments).expect('^ready$')
    found = run(probe())
    assert found.state is state
    assert run(send()) is (state is GoalState.UNKNOWN)
    assert count() == max(executed, 1 if state is GoalState.UNKNOWN else 0)
