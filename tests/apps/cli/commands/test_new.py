"""goalwire new: packages whose tests pass at once, that run, and that colcon installs."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.command_line import CommandLine, executable
from helpers.environments import Environment, made_once
from helpers.fresh import clean_environment
from helpers.isolation import isolated_env
from helpers.processes import Program

KINDS = {
    '--node': ['node'],
    '--service': ['switch_server'],
    '--action': ['count_server'],
    '--node --service --action --interfaces': ['node', 'switch_server', 'count_server'],
}


@pytest.fixture
def goalwire() -> CommandLine:
    """`goalwire` in a world of its own."""
    return CommandLine(isolated_env('rmw_zenoh_cpp'))


def pass_own_tests(python: Path | str, workspace: Path, package: str) -> str:
    """Run a package's own tests from the folder above it, and return their last line."""
    done = subprocess.run(
        [python, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', '-p', 'no:xdist', package],
        cwd=workspace, env=clean_environment(), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize('options', KINDS)
def test_a_new_package_passes_its_own_tests(goalwire: CommandLine, tmp_path: Path, options: str) -> None:
    where = ('--destination-directory', str(tmp_path))
    out = goalwire.ok('new', 'my_lamp', *options.split(), *where, program='goalwire')
    programs = KINDS[options]
    assert out.splitlines()[-1].endswith(f'python -m pytest my_lamp; ros2 run my_lamp my_lamp_{programs[0]}')
    assert pass_own_tests(sys.executable, tmp_path, 'my_lamp').startswith(f'{len(programs)} passed')


def test_without_pytest_the_next_step_is_to_install_it(goalwire: CommandLine, tmp_path: Path) -> None:
    (tmp_path / 'sitecustomize.py').write_text("import sys\nsys.modules['pytest'] = None\n")
    where = ('--destination-directory', str(tmp_path))
    out = goalwire.ok('new', 'my_lamp', *where, program='goalwire', PYTHONPATH=str(tmp_path))
    assert out.splitlines()[-1].startswith(
        f'next: cd {tmp_path}; pip install pytest; python -m pytest my_lamp;'
    )


def install_new(folder: Path) -> None:
    """Make a package of everything, and install it editable, without goalwire, which no index has to have."""
    source = folder / 'ws'
    source.mkdir()
    new = [str(executable('goalwire')), 'new', 'my_lamp', '--node', '--service', '--action', '--interfaces']
    subprocess.run(new, cwd=source, env=clean_environment(), check=True, capture_output=True, timeout=60)
    environment = Environment.create(folder / 'venv')
    environment.install_editable(f'{source}/my_lamp[test]', source / 'my_lamp_interfaces')


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.skipif(sys.platform == 'win32', reason='prefixes of links')
def test_a_new_package_with_interfaces_is_installed_tested_run_and_launched(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    installed = made_once(tmp_path_factory, 'new-package', install_new)
    python = Environment(installed / 'venv').python
    assert pass_own_tests(python, installed / 'ws', 'my_lamp').startswith('3 passed')
    world = isolated_env('rmw_zenoh_cpp') | {'XDG_CACHE_HOME': str(tmp_path / 'cache')}
    cli = '-m', 'goalwire'
    launch = ['my_lamp', 'my_lamp.launch.py']
    with Program(
        Path('-m'), 'goalwire', 'launch', *launch, python=python, env=world, cwd=tmp_path
    ) as launched:
        call = [
            'service',
            'call',
            '/switch',
            'my_lamp_interfaces/srv/Switch',
            '{data: true}',
            '--timeout',
            '30',
        ]
        done = subprocess.run(
            [python, *cli, *call],
            cwd=tmp_path, env=world, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        assert "Switch_Response(success=True, message='on')" in done.stdout, done.stdout + done.stderr
        launched.send_signal(signal.SIGINT)
        launched.wait()
    run = ['run', 'my_lamp', 'my_lamp_node', '--ros-args', '-p', 'name:=me']
    with Program(Path('-m'), 'goalwire', *run, python=python, env=world, cwd=tmp_path) as node:
        echo = ['topic', 'echo', '--once', '/greeting', 'my_lamp_interfaces/msg/Greeting']
        done = subprocess.run(
            [python, *cli, *echo],
            cwd=tmp_path, env=world, capture_output=True, text=True, timeout=60, check=False,
        )  # fmt: skip
        assert 'data: hello, me' in done.stdout, done.stdout + done.stderr
        node.send_signal(signal.SIGINT)
        node.wait()


def test_it_runs_from_its_folder_and_answers(
    goalwire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    goalwire.ok('new', 'my_lamp', '--service', program='goalwire')
    with Program(executable(), 'run', 'my_lamp', 'my_lamp_switch_server', env=dict(goalwire.env)) as server:
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
    for name in ('package.xml', 'launch/my_lamp.launch.py', 'config/parameters.yaml'):
        assert (prefix / 'share' / 'my_lamp' / name).is_file()
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
