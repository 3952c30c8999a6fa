"""The humanoid's errand goes on whoever is killed: its runner, and the servers that it uses."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from helpers.processes import Program
from helpers.robot import ROOT, robot_env

ERRAND = ROOT / 'examples' / 'missions' / 'errand.py'
PARAMETERS = ROOT / 'examples' / 'missions' / 'servers.yaml'
RUN = 'from humanoid.cli import main; raise SystemExit(main())'
OTHERS = ('battery_service', 'joint_state_service', 'arm_action_server')
IN_TIME = 90.0


class World:
    """The servers of the robot, with journals, and runners of the errand."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.env = robot_env()
        self._folder = folder
        self._stack = stack

    def start(self, name: str) -> Program:
        """Start one program of the robot."""
        arguments = (name, '--ros-args', '--params-file', str(PARAMETERS))
        return self._stack.enter_context(Program(RUN, *arguments, env=self.env, cwd=self._folder))

    def runner(self) -> Program:
        return self.goalwire('mission', 'run', '--id', 'errand-1', f'{ERRAND}:errand')

    def goalwire(self, *arguments: str) -> Program:
        program = Program(Path('-m'), 'goalwire', *arguments, env=self.env, cwd=self._folder)
        return self._stack.enter_context(program)


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with ExitStack() as stack:
        yield World(tmp_path, stack)


@pytest.mark.slow
def test_the_errand_goes_on_where_its_runner_was_killed(world: World, tmp_path: Path) -> None:
    for name in OTHERS:
        world.start(name)
    world.start('navigation_action_server')
    for step in ('step 2: goal move_to_position begins', 'step 3: goal move_arm begins'):
        runner = world.runner()
        runner.expect(step, IN_TIME)
        runner.kill()
        runner.wait()
    last = world.runner()
    last.expect('^Mission succeeded: brought home', IN_TIME)
    for number in (2, 3, 4, 5):
        assert last.output.count(f'step {number}: goal') == 2  # it begins once, and is done once
    assert (tmp_path / 'move_arm.goals').exists()


@pytest.mark.long
def test_a_goal_is_sent_again_if_its_server_died_too(world: World) -> None:
    for name in OTHERS:
        world.start(name)
    base = world.start('navigation_action_server')
    runner = world.runner()
    goal = runner.expect('step 2: goal move_to_position begins, goal ([0-9a-f]+)', IN_TIME)[1]
    world.goalwire('action', 'attach', 'move_to_position', goal).expect('distance_remaining', IN_TIME)
    runner.kill()
    base.kill()
    base.wait()
    world.start('navigation_action_server')
    last = world.runner()
    last.expect('begun, then its server died: again', IN_TIME)
    last.expect('^Mission succeeded: brought home', IN_TIME)
