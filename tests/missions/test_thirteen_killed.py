"""The humanoid's thirteen steps, on real wires: programs are killed at boundaries of the mission.

tests/examples/test_missions_thirteen.py does so in memory, in virtual time. Here the runner and the robot are
processes, and a run takes half a minute and three seconds of a core. Every hundredth boundary is tried; with
`GOALWIRE_TEST_MISSION_EVERY=1 GOALWIRE_TEST_MISSION_WORLDS=10 make long` it is each one, in ten worlds side
by side. With `--junitxml FILE -o junit_family=xunit1` pytest writes the figures down.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

import pytest
from helpers.chance import fresh_chance
from helpers.forking import ForkServer
from helpers.processes import Program
from helpers.robot import ROOT, robot_env
from helpers.wires import DDS, require

PROGRAMS = Path(__file__).parent / 'programs'
EXAMPLE = ROOT / 'examples' / 'missions'
EVERY = int(os.environ.get('GOALWIRE_TEST_MISSION_EVERY', '100'))
WORLDS = int(os.environ.get('GOALWIRE_TEST_MISSION_WORLDS', '2'))
IN_TIME = 600.0
PRELOADED = (
    'goalwire.missions.runner',
    'goalwire.transport.dds',
    'goalwire.transport.zenoh',
    'humanoid.arm.server',
    'humanoid.battery.service',
    'humanoid.joints.service',
    'humanoid.navigation.server',
)
GOALS = 14
"""The goals that the robot accepts in an undisturbed run."""
_BOUNDARY = '^boundary: (?P<boundary>.*)'
_END = r'^end: (?P<passed>\d+) (?P<steps>\d+) (?P<state>[a-z ]+): (?P<why>.*)'


class Run(NamedTuple):
    """A mission during which programs were killed at a boundary, and how it ended."""

    boundary: str
    passed: int
    """How many boundaries its last runner passed."""
    steps: int
    state: str
    why: str
    executed: Counter[str]
    """How often each goal was begun by its server."""
    output: str

    @property
    def has_succeeded(self) -> bool:
        return (self.state, self.steps) == ('succeeded', 13)

    @property
    def asks(self) -> bool:
        return self.state in {'lost step', 'approval'}


class Site:
    """Runs the mission, each time with a new robot, in one of several worlds."""

    def __init__(self, network: str, folder: Path, server: ForkServer) -> None:
        self._folder = folder
        self._server = server
        self._free: SimpleQueue[dict[str, str]] = SimpleQueue()
        for _ in range(WORLDS):
            self._free.put(robot_env(network))

    def run(self, victims: str, boundary: int) -> Run:
        """Kill the victims at the boundary with this number, start them again, and wait for the end."""
        env = self._free.get()
        try:
            return self._run(victims, boundary, env)
        finally:
            self._free.put(env)

    def _run(self, victims: str, boundary: int, env: dict[str, str]) -> Run:
        folder = self._folder / f'boundary-{boundary}'
        folder.mkdir()
        executions = folder / 'executions.txt'
        programs: list[Program] = []

        def start(name: str, *arguments: str) -> Program:
            program = Program(PROGRAMS / name, *arguments, env=env, server=self._server)
            programs.append(program)
            return stack.enter_context(program)

        def start_robot() -> Program:
            robot = start('humanoid_robot.py', str(executions))
            robot.expect('^ready$')
            return robot

        def start_runner(number: int) -> Program:
            return start('thirteen_runner.py', str(EXAMPLE), str(folder / 'missions.db'), str(number))

        with ExitStack() as stack:
            robot, runner = start_robot(), start_runner(boundary)
            reached = runner.expect(f'{_BOUNDARY}|{_END}', IN_TIME)
            end = reached
            if reached['boundary'] is not None:
                if victims != 'client':
                    robot.close()
                    start_robot()
                if victims != 'server':
                    runner.close()
                    runner = start_runner(-1)
                else:
                    runner.write_line('')
                end = runner.expect(_END, IN_TIME)
        return Run(
            reached['boundary'] or '',
            int(end['passed']),
            int(end['steps']),
            end['state'],
            end['why'],
            Counter(executions.read_text(encoding='utf-8').splitlines()),
            '\n'.join(program.output for program in programs),
        )


@pytest.mark.long
@pytest.mark.timeout(7200)
@pytest.mark.parametrize('victims', ['client', 'server', 'both'])
@pytest.mark.parametrize('network', ['rmw_zenoh_cpp', DDS])
def test_each_goal_is_executed_once_or_the_mission_asks(
    network: str, victims: str, tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    require(network)
    chance = fresh_chance(record_property)
    with ForkServer(PRELOADED, robot_env(network)) as server, ThreadPoolExecutor(WORLDS) as pool:
        site = Site(network, tmp_path, server)
        undisturbed = site.run(victims, -1)
        assert undisturbed.has_succeeded, undisturbed
        assert len(undisturbed.executed) == GOALS
        chosen = range(chance.randrange(EVERY), undisturbed.passed - 1, EVERY)
        runs = list(pool.map(lambda boundary: site.run(victims, boundary), chosen))
    asks = [run for run in runs if run.asks]
    record_property('boundaries', len(runs))
    record_property('succeeded', sum(run.has_succeeded for run in runs))
    record_property('lost', sum(run.state == 'lost step' for run in runs))
    record_property('approvals', sum(run.state == 'approval' for run in runs))
    record_property('asks', '\n'.join(f'{run.boundary}: {run.state}: {run.why}' for run in asks))
    for run in runs:
        assert set(run.executed.values()) <= {1}, f'a goal was executed twice: {run}'
        assert run.asks or run.has_succeeded, f'the mission neither succeeds nor asks: {run}'
