"""Runner and server are killed by SIGKILL at random moments, on real wires: each goal is executed once.

`GOALWIRE_TEST_MISSION_KILLS=300 make long` kills that often in each case. The server notes each execution in
a file of its own, and a tap notes each goal on the wire; on DDS the tap needs root. Pytest's `--junitxml FILE
-o junit_family=xunit1` writes the figures down.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from uuid import uuid4

import pytest
from helpers.chance import fresh_chance
from helpers.isolation import isolated_env
from helpers.killed_missions import (
    IN_TIME,
    World,
    assert_each_was_executed_once,
    assert_none_was_sent_to_a_server_that_knew_it,
    may_read_packets,
)
from helpers.processes import Program
from helpers.wires import DDS, require

PROGRAMS = Path(__file__).parent / 'programs'
ZENOH = 'rmw_zenoh_cpp'
TAPS = {ZENOH: PROGRAMS / 'tap.py', DDS: PROGRAMS / 'tap_dds.py'}
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '20'))


@contextmanager
def world_of(network: str, folder: Path, *, is_journalled: bool) -> Iterator[World]:
    """Yield a world in which everything runs; at the end everything is killed."""
    require(network)
    env = isolated_env(network)
    goals = (str(folder / 'drive.goals'),) if is_journalled else ()

    def start_base(executions: Path) -> Program:
        return Program(PROGRAMS / 'base.py', str(executions), *goals, env=env)

    with ExitStack() as stack:
        yield World(
            folder,
            stack,
            start_base=start_base,
            mission=PROGRAMS / 'rounds.py',
            places=2 * KILLS,
            env=env,
            tap=TAPS[network] if network == ZENOH or may_read_packets() else None,
        )


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize('victims', ['client', 'server', 'both'])
@pytest.mark.parametrize('server', ['stock', 'journalled'])
@pytest.mark.parametrize('network', [ZENOH, DDS])
def test_each_goal_is_executed_once_whoever_is_killed(
    network: str,
    server: str,
    victims: str,
    tmp_path: Path,
    record_property: Callable[[str, object], None],
) -> None:
    chance = fresh_chance(record_property)
    with world_of(network, tmp_path, is_journalled=server == 'journalled') as world:
        world.kill_often(victims, KILLS, chance)
    record_property('kills', world.kills)
    record_property('questions', world.questions())
    record_property('tapped', world.is_tapped)
    assert_each_was_executed_once(world)
    refused = [line[2] for line in world.lines(world.executions)]
    assert set(refused) == {'0'}, 'a server got an id that it knew'
    if world.is_tapped:
        assert_none_was_sent_to_a_server_that_knew_it(world)
    assert world.kills >= KILLS * 0.8


@pytest.mark.slow
@pytest.mark.parametrize('network', [ZENOH, pytest.param(DDS, marks=pytest.mark.long)])
def test_an_order_that_is_sent_again_after_its_runner_was_killed_is_carried_out_once(
    network: str, tmp_path: Path
) -> None:
    require(network)
    env, executions, order = isolated_env(network), tmp_path / 'executions.txt', str(uuid4())
    with ExitStack() as stack:

        def start(*command: Path | str) -> Program:
            source, *arguments = command
            return stack.enter_context(Program(Path(source), *map(str, arguments), env=env))

        def send() -> Program:
            return start('-m', 'goalwire', 'action', 'send_goal', 'fetch', 'order=3', '--goal-id', order)

        start(PROGRAMS / 'base.py', executions).expect('^ready$')
        for _ in range(2):
            runner = start(PROGRAMS / 'orders.py', tmp_path / 'missions.db')
            runner.expect('^ready$')
            sent = send()
            sent.expect('^Goal accepted', IN_TIME)
            runner.kill()  # on a busy machine the mission may have ended before
            runner.wait()
            sent.wait()
        start(PROGRAMS / 'orders.py', tmp_path / 'missions.db').expect('^ready$')
        send().expect('^Goal finished with status: SUCCEEDED', IN_TIME)
        again = send()
        again.expect('nothing is sent', IN_TIME)
        again.expect('^Goal finished with status: SUCCEEDED', IN_TIME)
    assert executions.read_text(encoding='utf-8').count('begun') == 1
