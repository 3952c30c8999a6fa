"""goalwire new: packages whose tests pass at once, that run, and that colcon installs."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.isolation import isolated_env
from helpers.processes import Program

PROGRAMS = {'--node': 'node', '--service': 'server', '--action': 'server'}


@pytest.fixture
def goalwire() -> CommandLine:
    """`goalwire` in a world of its own."""
    return CommandLine(isolated_env('rmw_zenoh_cpp'))


@pytest.mark.parametrize('kind', PROGRAMS)
def test_a_new_package_passes_its_own_tests(goalwire: CommandLine, tmp_path: Path, kind: str) -> None:
    out = goalwire.ok('new', 'my_lamp', kind, '--destination-directory', str(tmp_path), program='goalwire')
    assert out.splitlines()[-1].endswith(f'python -m pytest; ros2 run my_lamp my_lamp_{PROGRAMS[kind]}')
    tests = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-p', 'no:xdist'],
        cwd=tmp_path / 'my_lamp',
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert '1 passed' in tests.stdout, tests.stdout + tests.stderr


def test_it_runs_from_its_folder_and_answers(
    goalwire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    goalwire.ok('new', 'my_lamp', '--service', program='goalwire')
    with Program(executable(), 'run', 'my_lamp', 'my_lamp_server', env=dict(goalwire.env)) as server:
        answer = goalwire.ok('service', 'call', '/switch', '{data: true}', '--timeout', '20')
        assert "SetBool_Response(success=True, message='on')" in answer
        server.send_signal(signal.SIGINT)
        server.succeed()


def test_it_is_installed_as_colcon_does_with_its_program_where_ros2_run_looks(
    goalwire: CommandLine, tmp_path: Path
) -> None:
    goalwire.ok('new', 'my_lamp', '--destination-directory', str(tmp_path), program='goalwire')
    prefix = tmp_path / 'install'
    options = (
        '--single-version-externally-managed',
        '--record',
        str(tmp_path / 'record'),
        '--prefix',
        str(prefix),
    )
    install = [sys.executable, 'setup.py', '-q', 'install', *options]
    subprocess.run(install, cwd=tmp_path / 'my_lamp', check=True, capture_output=True, timeout=60)
    assert (prefix / 'lib' / 'my_lamp' / 'my_lamp_node').is_file()
    assert (prefix / 'share' / 'my_lamp' / 'package.xml').is_file()
    assert (prefix / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'my_lamp').is_file()
    assert len(list(prefix.rglob('my_lamp/node.py'))) == 1


@pytest.mark.parametrize(
    ('name', 'advice'),
    [('MyRobot', "write 'my_robot'"), ('my-robot', "write 'my_robot'"), ('class', 'as in my_robot')],
)
def test_what_is_no_name_of_a_package_is_refused_with_one_that_is(
    goalwire: CommandLine, tmp_path: Path, name: str, advice: str
) -> None:
    ended = goalwire('new', name, '--destination-directory', str(tmp_path), program='goalwire')
    assert ended.code == 4
    assert ended.err.splitlines()[-1].endswith(advice)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_there_is_left_alone(goalwire: CommandLine, tmp_path: Path) -> None:
    (tmp_path / 'lamp').mkdir()
    ended = goalwire('new', 'lamp', '--destination-directory', str(tmp_path), program='goalwire')
    assert ended.code == 1
    assert 'already; choose another name' in ended.err
    assert not list((tmp_path / 'lamp').iterdir())
