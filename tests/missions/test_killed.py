"""Runner and server are killed by SIGKILL at random moments, on real wires: each goal is executed once.

`GOALWIRE_TEST_MISSION_KILLS=300 make long` kills that often in each case, in GOALWIRE_TEST_MISSION_WORLDS
worlds side by side: most of a kill's time is waiting. The server notes each execution in a file of its own,
and a tap notes each goal on the wire; on DDS the tap needs root. Pytest's `--junitxml FILE -o
junit_family=xunit1` writes the figures down.
"""

from __future__ import annotations

import os
import random
import resource
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from uuid import uuid4

import pytest
from helpers.chance import fresh_chance
from helpers.forking import ForkServer
from helpers.isolation import isolated_env
from helpers.killed_missions import (
    IN_TIME,
    PRELOADED,
    World,
    assert_each_was_executed_once,
    assert_none_was_sent_to_a_server_that_knew_it,
    may_read_packets,
    ports_of,
)
from helpers.processes import Program
from helpers.wires import DDS, require

PROGRAMS = Path(__file__).parent / 'programs'
ZENOH = 'rmw_zenoh_cpp'
KILLS = int(os.environ.get('GOALWIRE_TEST_MISSION_KILLS', '20'))
WORLDS = int(os.environ.get('GOALWIRE_TEST_MISSION_WORLDS', '1'))
SHORT, LONG = '0.1', '2.0'
"""The seconds of a goal; every eighth is a long one."""
WITHIN = 0.5
PLACES = 24


class Worlds:
    """Worlds side by side, whose programs one process forks, and a tap."""

    def __init__(self, network: str, folder: Path, stack: ExitStack, *, is_journalled: bool) -> None:
        require(network)
        self._network = network
        self._folder = folder
        self._is_journalled = is_journalled
        self._stack = stack
        self._server = stack.enter_context(ForkServer(PRELOADED, isolated_env(network)))
        self._environments = [isolated_env(network) for _ in range(WORLDS)]
        self._packets = self._start_tap_of_packets() if network == DDS else None

    def _start_tap_of_packets(self) -> Path | None:
        """Start the tap that hears all worlds, if this process may read packets."""
        if not may_read_packets():
            return None
        heard = self._folder / 'heard.txt'
        ports = ports_of(*(env['ROS_DOMAIN_ID'] for env in self._environments))
        self._start(PROGRAMS / 'tap_dds.py', str(heard), *ports, env=isolated_env(self._network))
        return heard

    def _start(self, program: Path, *arguments: str, env: dict[str, str]) -> Program:
        started = self._stack.enter_context(Program(program, *arguments, env=env, server=self._server))
        started.expect('^ready$')
        return started

    @contextmanager
    def open(self, number: int) -> Iterator[World]:
        """Yield a world in which everything runs; at the end everything is killed."""
        folder, env = self._folder / f'world-{number}', self._environments[number]
        folder.mkdir()
        goals = (str(folder / 'drive.goals'),) if self._is_journalled else ()

        def start_base(executions: Path) -> Program:
            arguments = (str(executions), SHORT, LONG, *goals)
            return Program(PROGRAMS / 'base.py', *arguments, env=env, server=self._server)

        heard = self._packets
        if self._network == ZENOH:
            heard = folder / 'heard.txt'
            self._start(PROGRAMS / 'tap.py', str(heard), env=env)
        with ExitStack() as stack:
            yield World(
                folder,
                stack,
                start_base=start_base,
                mission=PROGRAMS / 'rounds.py',
                places=PLACES,
                env=env,
                heard=heard,
                server=self._server,
                within=WITHIN,
            )

    def kill_often(self, number: int, victims: str, seed: float) -> World:
        """Kill in one world; return it after its end."""
        with self.open(number) as world:
            world.kill_often(victims, KILLS // WORLDS, random.Random(seed))
        return world


def cpu_s() -> float:
    """Return the CPU time that this process and its children, those that have ended, have had."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


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
    seeds = [chance.random() for _ in range(WORLDS)]
    before = cpu_s()
    with ExitStack() as stack:
        worlds = Worlds(network, tmp_path, stack, is_journalled=server == 'journalled')
        pool = stack.enter_context(ThreadPoolExecutor(WORLDS))
        futures = [pool.submit(worlds.kill_often, i, victims, seed) for i, seed in enumerate(seeds)]
        killed = [future.result() for future in futures]
    kills = sum(world.kills for world in killed)
    record_property('kills', kills)
    record_property('questions', sum(world.questions() for world in killed))
    record_property('goals', sum(world.missions * world.places for world in killed))
    record_property('tapped', all(world.heard is not None for world in killed))
    record_property('cpu_s_a_kill', f'{(cpu_s() - before) / kills:.3f}')
    for world in killed:
        assert_each_was_executed_once(world)
        refused = [line[2] for line in world.lines(world.executions)]
        assert set(refused) == {'0'}, 'a server got an id that it knew'
        if world.heard is not None:
            assert_none_was_sent_to_a_server_that_knew_it(world)
    assert kills == KILLS // WORLDS * WORLDS


@pytest.mark.slow
@pytest.mark.parametrize('end', [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.long)])
@pytest.mark.parametrize('network', [ZENOH, pytest.param(DDS, marks=pytest.mark.long)])
def test_an_order_that_is_sent_again_after_its_runner_has_ended_is_carried_out_once(
    network: str, end: signal.Signals, tmp_path: Path
) -> None:
    require(network)
    env, executions, order = isolated_env(network), tmp_path / 'executions.txt', str(uuid4())
    with ExitStack() as stack:

        def start(*command: Path | str) -> Program:
            source, *arguments = command
            return stack.enter_context(Program(Path(source), *map(str, arguments), env=env))

        def send() -> Program:
            return start('-m', 'goalwire', 'action', 'send_goal', 'fetch', 'order=3', '--goal-id', order)

        start(PROGRAMS / 'base.py', executions, '0.5', '5.0').expect('^ready$')
        for _ in range(2):
            runner = start(PROGRAMS / 'orders.py', tmp_path / 'missions.db')
            runner.expect('^ready$')
            sent = send()
            sent.expect('^Goal accepted', IN_TIME)
            runner.send_signal(end)  # on a busy machine the mission may have ended before
            runner.wait()
            sent.wait()
            assert 'ABORTED' not in sent.output, runner.output + '\n' + sent.output  # the mission goes on
        start(PROGRAMS / 'orders.py', tmp_path / 'missions.db').expect('^ready$')
        send().expect('^Goal finished with status: SUCCEEDED', IN_TIME)
        again = send()
        again.expect('nothing is sent', IN_TIME)
        again.expect('^Goal finished with status: SUCCEEDED', IN_TIME)
    assert executions.read_text(encoding='utf-8').count('begun') == 1
