"""humanoid status, wave, move, arm and watch: what a person types beside a robot that is up."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from helpers.command_line import CommandLine
from helpers.processes import Program
from helpers.robot import humanoid, robot_env

COMMAND = 120.0  # s: only a failure takes as long

pytestmark = pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX')


@pytest.fixture(scope='module')
def env() -> dict[str, str]:
    """A world of its own."""
    return robot_env()


@pytest.fixture(scope='module')
def up(env: dict[str, str]) -> Iterator[Program]:
    """A humanoid that is up."""
    with humanoid('up', env=env) as program:
        for _ in range(5):
            program.expect('((Service|Server) ready|Robot initialized)', COMMAND)
        yield program


def said(env: dict[str, str], *arguments: str, code: int = 0) -> str:
    """Run a command, which ends with `code`; return its output."""
    with humanoid(*arguments, env=env) as program:
        assert program.wait() == code, program.output
    assert 'Traceback' not in program.output
    return program.output


@pytest.mark.usefixtures('up')
def test_status_shows_joints_base_and_battery(env: dict[str, str]) -> None:
    lines = said(env, 'status').splitlines()
    assert lines[0].split()[:3] == ['left_arm_shoulder', '0.500', 'rad']
    assert [line.split()[0] for line in lines[-2:]] == ['base', 'battery']


@pytest.mark.usefixtures('up')
def test_an_arm_goes_where_it_is_sent_and_status_shows_it(env: dict[str, str]) -> None:
    moved = re.fullmatch(r'left_arm_elbow at (\d\.\d{3}) rad', said(env, 'arm', 'left_arm_elbow', '0.6'))
    assert moved
    assert float(moved[1]) == pytest.approx(0.6, abs=0.015)  # a busy machine reads it before the last ticks
    assert re.search(r'left_arm_elbow             0\.(59|60)\d rad', said(env, 'status'))


@pytest.mark.usefixtures('up')
def test_it_waves(env: dict[str, str]) -> None:
    assert said(env, 'wave') == 'waved'


@pytest.mark.usefixtures('up')
def test_it_moves_and_is_watched_on_its_way(env: dict[str, str]) -> None:
    with humanoid('watch', env=env) as watch:
        watch.expect(r'base at \(.*\) m, 0\.00 m/s; joints still')
        assert said(env, 'move', '1.0', '-0.5').startswith('at (1.00, -0.50) m after ')
        watch.expect(r'base at \(1\.00, -0\.50\) m, 0\.00 m/s')
        watch.send_signal(signal.SIGINT)
        assert watch.wait() == 130
    assert watch.output.splitlines()[-1] == 'stopped'


@pytest.mark.usefixtures('up')
def test_it_drives_home_from_where_it_is(env: dict[str, str]) -> None:
    said(env, 'move', '2.0', '1.0')
    assert 'aborted: Timed out after 0.2 s' in said(env, 'home', '--timeout', '0.2', code=1)
    assert said(env, 'home').startswith('home: at (0.00, 0.00) m after ')
    assert said(env, 'home').startswith('home: at (0.00, 0.00) m after '), 'it is there already'


@pytest.mark.slow
@pytest.mark.usefixtures('up')
def test_a_mission_drives_home_first(env: dict[str, str]) -> None:
    said(env, 'move', '-0.6', '0.8')
    with humanoid('mission', env=env) as mission:
        mission.expect('^the base is 1.00 m from home: it drives there first$')
        mission.expect(r'^\[3/10\] raise the left arm')
        mission.send_signal(signal.SIGINT)
        assert mission.wait() == 130
    assert 'FAILED' not in mission.output


@pytest.mark.usefixtures('up')
def test_ctrl_c_stops_the_robot(env: dict[str, str]) -> None:
    with humanoid('watch', env=env) as watch, humanoid('move', '50', '0', env=env) as move:
        watch.expect(r'm, 0\.[1-9]\d* m/s')
        move.send_signal(signal.SIGINT)
        assert move.wait() == 130
        assert move.output.splitlines()[-1] == 'stopped'
        watch.expect(r'm, 0\.00 m/s')
        watch.send_signal(signal.SIGINT)
        assert watch.wait() == 130


@pytest.mark.usefixtures('up')
@pytest.mark.parametrize(
    ('arguments', 'complaint'),
    [
        (('arm', 'left_arm_elbo', '1'), "there is no joint 'left_arm_elbo'; did you mean 'left_arm_elbow'?"),
        (('arm', 'left_arm_elbow', '9'), 'the goal was refused: left_arm_elbow goes from 0.0 to 2.4 rad'),
        (('move', '2000', '0'), 'the goal was refused: the target must be within 1000 m'),
    ],
)
def test_what_cannot_be_done_is_said_with_what_can(
    env: dict[str, str], arguments: tuple[str, ...], complaint: str
) -> None:
    assert complaint in said(env, *arguments, code=1)


@pytest.mark.usefixtures('up')
def test_a_goal_that_the_emergency_stop_refuses_says_so(env: dict[str, str]) -> None:
    switch = CommandLine(env)
    stop = ('service', 'call', 'emergency_stop', 'std_srvs/srv/SetBool')
    switch.ok(*stop, '{data: true}')
    try:
        for goal in (('move', '1.0', '0.0'), ('home',), ('arm', 'left_arm_elbow', '1.0')):
            assert 'the goal was refused: emergency stop: nothing moves until' in said(env, *goal, code=1)
    finally:
        switch.ok(*stop, '{data: false}')


def test_without_a_robot_it_says_how_to_start_one() -> None:
    output = said(robot_env(), 'wave', code=1)
    assert 'get_joint_state: no server within 2.0 s; is the robot up? start it with: humanoid up' in output


@pytest.mark.parametrize('command', ['status', 'mission', 'battery_service'])
def test_arguments_of_ros_2_that_cannot_be_read_are_told_in_one_line(
    env: dict[str, str], command: str
) -> None:
    output = said(env, command, '--ros-args', '-r', 'bad::=:', code=1)
    assert "failed to initialize rcl: Couldn't parse remap rule: '-r bad::=:'" in output
    assert output.startswith('humanoid')
    assert len(output.splitlines()) == 1


@pytest.mark.usefixtures('up')
@pytest.mark.parametrize('command', ['status', 'watch', '--help', 'up'])
def test_output_that_nobody_reads_ends_a_command_quietly(env: dict[str, str], command: str) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    try:
        ended = subprocess.run(
            [sys.executable, '-m', 'humanoid', command],
            env=(robot_env() if command == 'up' else env) | {'PYTHONUNBUFFERED': ''},
            stdin=subprocess.DEVNULL,
            stdout=writer,
            stderr=subprocess.PIPE,
            text=True,
            timeout=COMMAND,
            check=False,
        )
    finally:
        os.close(writer)
    assert (ended.returncode, ended.stderr) == (141, '')


@pytest.mark.usefixtures('up')
def test_a_second_ctrl_c_leaves_at_once(env: dict[str, str]) -> None:
    with humanoid('watch', env=env) as watch, humanoid('move', '50', '0', env=env) as move:
        watch.expect(r'm, 0\.[1-9]\d* m/s')
        move.send_signal(signal.SIGINT)
        move.send_signal(signal.SIGINT)
        assert move.wait() == 130
    assert 'Traceback' not in move.output
