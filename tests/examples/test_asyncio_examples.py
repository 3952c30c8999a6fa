"""The programs of examples/asyncio/, each a process of its own; and servers that are killed."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TypeAlias

import pytest
from example_interfaces.action import Fibonacci
from helpers.held_up import HeldUp
from helpers.isolation import NETWORK, isolated_env, lease_variables
from helpers.loops import run
from helpers.processes import Program
from helpers.wires import DDS

import goalwire

pytestmark = pytest.mark.slow

EXAMPLES = Path(__file__).parents[2] / 'examples' / 'asyncio'

Start: TypeAlias = Callable[..., Program]


@pytest.fixture
def start(monkeypatch: pytest.MonkeyPatch) -> Iterator[Start]:
    """`start(name, *arguments, **variables)` runs an example, in the world that this process is in, too."""
    env = isolated_env(NETWORK)
    for name, value in env.items():
        monkeypatch.setenv(name, value)
    with ExitStack() as stack:
        yield lambda name, *arguments, **variables: stack.enter_context(
            Program(EXAMPLES / f'{name}.py', *arguments, env=env | variables)
        )


def test_the_listener_hears_the_talker_until_both_are_stopped(start: Start) -> None:
    programs = [start('listener'), start('talker')]
    number = int(programs[0].expect(r'Heard: Hello number (\d+)')[1])
    programs[0].expect(f'Heard: Hello number {number + 1}$')
    for program in programs:
        program.send_signal(signal.SIGINT)
    for program in programs:
        assert 'Traceback' not in program.succeed()


def test_the_client_waits_for_its_server(start: Start) -> None:
    client = start('add_two_ints_client', '40', '2')
    server = start('add_two_ints_server')
    assert client.succeed() == '40 + 2 = 42'
    server.send_signal(signal.SIGINT)
    assert 'Traceback' not in server.succeed()


def test_goals_succeed_are_refused_run_out_of_time_and_are_cancelled_by_ctrl_c(start: Start) -> None:
    start('fibonacci_action_server')
    assert start('fibonacci_action_client', '2').succeed().splitlines() == [
        'So far: [0, 1, 1]',
        'Result: [0, 1, 1]',
    ]
    refused, late, stopped = (
        start('fibonacci_action_client', *arguments) for arguments in (['47'], ['40', '1.5'], ['40'])
    )
    stopped.expect('So far')
    stopped.send_signal(signal.SIGINT)
    assert stopped.wait() == 1
    assert stopped.output.endswith('Cancelled')
    assert refused.wait() == 1
    assert "of node '/fibonacci_action_server': the server refused the goal" in refused.output
    assert late.wait() == 1
    assert 'no answer came in time; waited 1.' in late.output


def test_a_killed_server_loses_its_goals_within_a_second_or_its_lease(start: Start) -> None:
    """Zenoh tells of a death at once; on DDS nobody does, so it shows when the lease ends."""

    async def scenario() -> None:
        async with goalwire.Node('caller') as node:
            async with node.action(Fibonacci, 'fibonacci').send(order=40, timeout=20.0) as goal:
                await anext(aiter(goal.feedback))
                held_up = HeldUp()
                server.kill()
                killed = time.monotonic()
                with pytest.raises(goalwire.ServerLostError, match="of node '/fibonacci_action_server'") as e:
                    await goal.result
                assert time.monotonic() - killed < 1.0 + lease_s + held_up.seconds
            assert e.value.name == '/fibonacci'

    lease_s = 2.0 if NETWORK == DDS else 0.0
    server = start('fibonacci_action_server', **lease_variables(lease_s) if lease_s else {})
    run(scenario())
