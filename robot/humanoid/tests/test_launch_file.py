"""humanoid.launch.py brings the robot up, and leaves nothing behind."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from shutil import copytree

import pytest
from goalwire.launching.source_programs import interpreter_lines
from helpers.command_line import CommandLine, executable
from helpers.processes import Program
from helpers.robot import ROOT, robot_env, wait_until_gone

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='processes are watched by pidfd')

SERVERS = (
    'joint_state_service',
    'navigation_action_server',
    'battery_service',
    'arm_action_server',
    'robot_state_publisher',
)


@pytest.fixture
def world(tmp_path: Path) -> dict[str, str]:
    """The package installed as colcon would install it."""
    source = ROOT / 'robot' / 'humanoid'
    copytree(source / 'launch', tmp_path / 'share' / 'humanoid' / 'launch')
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'humanoid').touch()
    programs = tmp_path / 'lib' / 'humanoid'
    programs.mkdir(parents=True)
    for name in (*SERVERS, 'simulation', 'mission'):
        program = programs / name
        call = f'from humanoid.cli import main\nimport sys\nsys.argv.insert(1, {name!r})\nsys.exit(main())\n'
        program.write_text(f'{interpreter_lines(sys.executable)}\n{call}')
        program.chmod(0o755)
    return {**robot_env(), 'AMENT_PREFIX_PATH': str(tmp_path)}


@pytest.fixture
def robot(world: dict[str, str]) -> Iterator[Program]:
    with Program(
        executable(), 'launch', 'humanoid', 'humanoid.launch.py', 'namespace:=h1', env=world
    ) as launched:
        yield launched
        launched.send_signal(signal.SIGINT)
        assert launched.wait() == 130


def test_the_launch_file_starts_the_servers(robot: Program, world: dict[str, str]) -> None:
    pids = [int(robot.expect(r'process started with pid \[(\d+)\]')[1]) for _ in SERVERS]
    robot.expect('Battery Service ready', timeout=40.0)  # five programs start at once
    called = CommandLine(world)(
        'service', 'call', '/h1/get_battery_status', 'humanoid_interfaces/srv/GetBatteryStatus', '{}',
        '--timeout', '30',  # five programs start at once
    )  # fmt: skip
    assert called.code == 0
    assert 'percentage' in called.out
    frame = CommandLine(world).ok('topic', 'echo', '/h1/odom', '--once', '--field', 'child_frame_id')
    assert frame.splitlines()[0] == 'h1/base_link', 'robots share /tf, so their frames have their names'
    robot.send_signal(signal.SIGINT)
    assert robot.wait() == 130
    output = robot.output
    assert output.count('process has finished cleanly') == len(SERVERS), output
    assert 'nothing used' not in output, 'a parameter went to a program that has none of that name'
    assert all(wait_until_gone(pid, 10.0) for pid in pids)


def test_with_physics_one_simulation_stands_in_for_joints_and_base(world: dict[str, str]) -> None:
    pytest.importorskip('mujoco', reason='the physics is MuJoCo')
    arguments = ['humanoid', 'humanoid.launch.py', 'namespace:=h1', 'physics:=true', 'use_sim_time:=true']
    with Program(executable(), 'launch', *arguments, env=world) as launched:
        started = [launched.expect(r'\[(\w+)-\d+\]: process started with pid')[1] for _ in range(4)]
        assert sorted(started) == sorted({'simulation', *SERVERS} - set(SERVERS[:2]))
        launched.expect('h1.simulation.*Simulation ready')
        launched.send_signal(signal.SIGINT)
        assert launched.wait() == 130, launched.output


def test_its_arguments_are_told(world: dict[str, str]) -> None:
    shown = CommandLine(world).ok('launch', 'humanoid', 'humanoid.launch.py', '--show-args')
    names = [line.strip(" ':") for line in shown.splitlines() if line.startswith("    '")]
    assert names == [
        'namespace', 'frame_prefix', 'map_frame', 'place', 'physics', 'world', 'use_sim_time', 'mission',
        'log_level',
    ]  # fmt: skip


def test_the_package_installs_it() -> None:
    assert "['launch/humanoid.launch.py']" in (ROOT / 'robot' / 'humanoid' / 'setup.py').read_text()
