"""The humanoid installed by pip runs from any folder, and beside another one."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from shlex import quote

import pytest
from helpers.environments import made_once
from helpers.fresh import clean_environment
from helpers.processes import Program
from helpers.robot import ROOT, robot_env
from helpers.robot import humanoid as robot_program
from tools.humanoid_shells import SHELLS

from humanoid import domain_search

pytestmark = [pytest.mark.slow, pytest.mark.timeout(400)]

WHOLE = '10 of 10 steps ended as they should'
DEFINITIONS = {
    'package.xml',
    'action/MoveArm.action',
    'action/MoveToPosition.action',
    'srv/GetBatteryStatus.srv',
    'msg/Contact.msg',
    'msg/Contacts.msg',
    'srv/GetJointState.srv',
    'srv/Push.srv',
}
DESCRIPTION = {'package.xml', 'urdf/humanoid.urdf', *(f'meshes/{name}.stl' for name in SHELLS)}
MAKES = """
import subprocess, sys
raise SystemExit(subprocess.run(sys.argv[1:], check=False).returncode)
"""


def _run(*arguments: str, cwd: Path) -> None:
    """Run a module of the tests' Python; it must succeed."""
    done = subprocess.run(
        [sys.executable, '-m', *arguments],
        cwd=cwd, env=clean_environment(), capture_output=True, text=True, timeout=200, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr + done.stdout


def _install(source: str, folder: str, *, cwd: Path) -> None:
    """Install a package into a folder, built by the tests' own setuptools: no package index is needed."""
    options = ['--quiet', '--no-deps', '--no-index', '--no-build-isolation', '--no-compile']
    _run('pip', 'install', *options, '--target', folder, source, cwd=cwd)


@pytest.fixture(scope='session')
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of robot/, without what builds leave there."""
    copy = tmp_path_factory.mktemp('copy') / 'robot'
    left = shutil.ignore_patterns('build', '*.egg-info', '__pycache__', '.*_cache')
    shutil.copytree(ROOT / 'robot', copy, ignore=left)
    return copy


@pytest.fixture(scope='session')
def site(sources: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where `pip install ./robot/humanoid` has put the robot."""
    return made_once(
        tmp_path_factory, 'site', lambda folder: _install('./humanoid', str(folder), cwd=sources)
    )


@pytest.fixture
def env(site: Path, tmp_path: Path) -> dict[str, str]:
    """A user's environment: no domain chosen, no interfaces named. Claims of domains are the test's own."""
    env = robot_env() | {'PYTHONPATH': str(site), 'TMPDIR': str(tmp_path)}
    del env['GOALWIRE_INTERFACE_PATH'], env['ROS_DOMAIN_ID']
    return env


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    folder = tmp_path / 'elsewhere'
    folder.mkdir()
    return folder


def humanoid(*arguments: str, env: dict[str, str], cwd: Path) -> Program:
    """Run the installed robot; `make demo` below begins with an interpreter of its own, as a user does."""
    return robot_program(*arguments, env=env, cwd=cwd, site=Path(env['PYTHONPATH']))


def definitions(folder: Path) -> set[str]:
    return {str(file.relative_to(folder)) for file in folder.rglob('*') if file.is_file()}


def widest(lines: Sequence[str]) -> int:
    return max(len(line) for line in lines if 'WARN' not in line and 'INFO' not in line)


@pytest.mark.long
def test_the_definitions_come_with_the_package_and_with_its_sdist(
    sources: Path, site: Path, tmp_path: Path
) -> None:
    assert definitions(site / 'humanoid_definitions') == DEFINITIONS
    assert definitions(site / 'humanoid_description') == DESCRIPTION
    _run('build', '--sdist', '--no-isolation', '--outdir', str(tmp_path), './humanoid', cwd=sources)
    [sdist] = tmp_path.glob('*.tar.gz')
    _install(str(sdist), 'from_sdist', cwd=tmp_path)
    assert definitions(tmp_path / 'from_sdist' / 'humanoid_definitions') == DEFINITIONS
    assert definitions(tmp_path / 'from_sdist' / 'humanoid_description') == DESCRIPTION
    assert definitions(tmp_path / 'from_sdist' / 'share' / 'humanoid_description') == DESCRIPTION
    names = {path.name for path in sources.iterdir()}
    packages = {'humanoid', 'humanoid_description', 'humanoid_interfaces'}
    assert names == {*packages, 'ruff.toml'}, 'the sdist left something behind'


def test_every_definition_is_installed() -> None:
    home = ROOT / 'robot' / 'humanoid_interfaces'
    assert definitions(home) - {'CMakeLists.txt'} == DEFINITIONS


def test_the_description_is_found_from_any_folder(env: dict[str, str], site: Path, elsewhere: Path) -> None:
    program = 'from humanoid.description import urdf_path; print(urdf_path())'
    with Program(program, env=env, cwd=elsewhere) as asked:
        assert asked.succeed().strip() == str(site / 'humanoid_description' / 'urdf' / 'humanoid.urdf')


def test_the_helps_fit_a_terminal_of_60_columns(env: dict[str, str], elsewhere: Path) -> None:
    for arguments in (['--help'], ['up', '--help'], ['demo', '--help'], ['mission', '--help']):
        with humanoid(*arguments, env=env | {'COLUMNS': '60'}, cwd=elsewhere) as program:
            lines = program.succeed(timeout=90.0).splitlines()
        assert widest(lines) <= 60, arguments


def test_a_demo_beside_up_takes_a_domain_and_a_second_up_says_what_to_do(
    env: dict[str, str], elsewhere: Path
) -> None:
    with humanoid('up', env=env, cwd=elsewhere) as up:
        up.expect('Arm Action Server ready')
        with humanoid('up', env=env, cwd=elsewhere) as second:
            assert second.wait() == 1
            assert re.search(
                r'^humanoid: a humanoid is running already in ROS domain 0: stop it.*ROS_DOMAIN_ID',
                second.output,
            )
        with humanoid('demo', env=env | {'ROS_DOMAIN_ID': '0'}, cwd=elsewhere) as fixed:
            assert fixed.wait() == 1
            assert 'in ROS domain 0, which ROS_DOMAIN_ID names: stop it, or choose another' in fixed.output
        with humanoid('demo', env=env, cwd=elsewhere) as demo:
            demo.expect('this one takes ROS_DOMAIN_ID=1', 90.0)
            demo.expect(r'^\[2/10\]', 90.0)


@pytest.mark.parametrize(
    'server', [pytest.param('joint_state_service', marks=pytest.mark.long), 'navigation_action_server']
)
def test_a_demo_sees_a_server_that_was_started_alone(
    env: dict[str, str], elsewhere: Path, server: str
) -> None:
    """All servers share the domain's lock by the same `humanoid.running`; one of them shows it."""
    with humanoid(server, env=env, cwd=elsewhere) as alone:
        alone.expect('ready')
        with humanoid('demo', env=env, cwd=elsewhere) as demo:
            demo.expect('a humanoid is running already in ROS domain 0: this one takes ROS_DOMAIN_ID=1', 90.0)
            demo.expect(r'^\[2/10\]', 90.0)


def test_servers_that_no_lock_tells_of_are_found_in_the_domain(env: dict[str, str], elsewhere: Path) -> None:
    """As on another machine, which has its own files; the look may come before the server is known."""
    looks = Path(domain_search.__file__)
    with humanoid('up', env=env, cwd=elsewhere) as up:
        up.expect('Arm Action Server ready')
        code = 0
        while code != domain_search.SOMEBODY_IS_THERE:  # bounded by the test's time limit
            with Program(looks, env=env, cwd=elsewhere) as look:
                code = look.wait()


def test_a_domain_is_free_again_when_its_humanoid_was_killed(env: dict[str, str], elsewhere: Path) -> None:
    with humanoid('up', env=env, cwd=elsewhere) as up:
        up.expect('Arm Action Server ready')
        up.kill()
        up.wait()
    with humanoid('up', env=env, cwd=elsewhere) as again:
        again.expect('Ctrl-C stops them all')


def _demo(env: dict[str, str], cwd: Path, venv: Path) -> Program:
    """Run `make demo` of the checkout, which is set up already; `humanoid demo` where there is no make."""
    if os.name != 'posix' or shutil.which('make') is None:
        return humanoid('demo', env=env, cwd=cwd)
    command = [
        'make',
        '--silent',
        '--no-print-directory',
        '-C',
        str(ROOT),
        'demo',
        f'VENV={venv}',
        'RMW=rmw_zenoh_cpp',
    ]
    return Program(MAKES, *command, env=env, cwd=cwd)


@pytest.mark.long
def test_two_demos_at_once_from_any_folder_end_well_each_in_a_domain_of_its_own(
    env: dict[str, str], elsewhere: Path, tmp_path: Path
) -> None:
    """They leave nothing in the folder. One has a terminal of 60 columns, the other has none: 80 then."""
    env.pop('COLUMNS', None)
    narrow = env | {'COLUMNS': '60'}
    venv = tmp_path / 'venv'
    program = venv / 'bin' / 'humanoid'
    program.parent.mkdir(parents=True)
    program.with_name('python').symlink_to(sys.executable)
    program.write_text(f'#!/bin/sh\nexec {quote(sys.executable)} -m humanoid "$@"\n', encoding='utf-8')
    program.chmod(0o755)
    (venv / '.run-rmw_zenoh_cpp').touch()  # it is set up
    with _demo(env, elsewhere, venv) as one, _demo(narrow, elsewhere, venv) as other:
        outputs = [one.succeed(timeout=90.0), other.succeed(timeout=90.0)]
    for output, columns in zip(outputs, (80, 60), strict=True):
        assert widest([line for line in output.splitlines() if 'this one takes' not in line]) <= columns
    assert all(output.splitlines()[-1].startswith(WHOLE) for output in outputs)
    first, moved = sorted(outputs, key=lambda output: 'this one takes ROS_DOMAIN_ID=1' in output)
    assert 'this one takes ROS_DOMAIN_ID' not in first
    assert 'this one takes ROS_DOMAIN_ID=1' in moved
    assert list(elsewhere.iterdir()) == []
