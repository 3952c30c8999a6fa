"""Packages that are installed with `pip install -e`, by setuptools and by hatchling, as users do it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.environments import Environment, made_once
from helpers.fresh import clean_environment
from helpers.packages import write_package

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == 'win32', reason='prefixes of links'),
    pytest.mark.timeout(300),
]

SETUP = """\
from setuptools import setup

setup(
    name='@name@',
    version='1.2.3',
    packages=['@name@'],
    package_dir={'': '@where@'},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/@name@']),
        ('share/@name@', ['package.xml']),
        ('share/@name@/launch', ['launch/greet.launch.xml']),
    ],
    entry_points={'console_scripts': ['@name@_greet = @name@:greet']},
)
"""
HATCH = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "@name@"
version = "1.2.3"

[project.scripts]
@name@_greet = "@name@:greet"

[tool.hatch.build.targets.wheel]
packages = ["@name@"]
"""
CODE = """\
from pathlib import Path


def greet():
    print('hello from', Path(__file__).parent)
"""
LAUNCH = """\
<launch>
  <log message="share: $(find-pkg-share @name@)"/>
  <node pkg="@name@" exec="@name@_greet" output="screen"/>
</launch>
"""
PACKAGES = {
    'flat_robot': ('.', 'setup.py', SETUP),
    'src_robot': ('src', 'setup.py', SETUP),
    'hatch_robot': ('.', 'pyproject.toml', HATCH),
}
each = pytest.mark.parametrize('name', list(PACKAGES))


def write(workspace: Path, name: str) -> Path:
    where, build_file, build = PACKAGES[name]
    files = {
        f'{where}/{name}/__init__.py': CODE,
        f'resource/{name}': '',
        'launch/greet.launch.xml': LAUNCH,
        build_file: build,
    }
    filled = {file: text.replace('@name@', name).replace('@where@', where) for file, text in files.items()}
    return write_package(workspace / name, name, filled)


def make(folder: Path) -> None:
    """Fill the environment `venv` with the packages of `ws`, and with this goalwire."""
    sources = [write(folder / 'ws', name) for name in PACKAGES]
    Environment.create(folder / 'venv').install_editable(*sources)


@pytest.fixture(scope='session')
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the three packages, and their sources."""
    return made_once(tmp_path_factory, 'editable', make)


@pytest.fixture
def away(tmp_path: Path) -> Path:
    """A folder far from the sources."""
    folder = tmp_path / 'away'
    folder.mkdir()
    return folder


def ros2(installed: Path, away: Path, *arguments: str) -> str:
    """Run the command, which must succeed; return what it prints on both streams."""
    done = subprocess.run(
        [Environment(installed / 'venv').python, '-m', 'goalwire', *arguments],
        cwd=away, env=clean_environment(XDG_CACHE_HOME=str(away / 'cache')), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return done.stdout


@each
def test_its_programs_are_listed_and_run(installed: Path, away: Path, name: str) -> None:
    program = installed / 'venv' / 'bin' / f'{name}_greet'
    listed = ros2(installed, away, 'pkg', 'executables', name, '--full-path').strip()
    assert Path(listed).name == f'{name}_greet'
    assert Path(listed).resolve() == program
    where = PACKAGES[name][0]
    code = (installed / 'ws' / name / where / name).resolve()
    assert ros2(installed, away, 'run', name, f'{name}_greet') == f'hello from {code}\n'


@each
def test_its_manifest_and_its_launch_files_are_those_of_the_source(
    installed: Path, away: Path, name: str
) -> None:
    source = installed / 'ws' / name
    assert ros2(installed, away, 'pkg', 'prefix', '--share', name).strip() == str(source)
    assert f'<name>{name}</name>' in ros2(installed, away, 'pkg', 'xml', name)
    (prefix,) = ros2(installed, away, 'pkg', 'prefix', name).splitlines()
    assert Path(prefix, 'share', name).resolve() == source
    launched = ros2(installed, away, 'launch', name, 'greet.launch.xml')
    assert f'share: {source}' in launched
    assert 'hello from' in launched


def test_all_are_listed_wherever_the_command_is_started(installed: Path, away: Path) -> None:
    for folder in (away, installed / 'ws'):
        assert set(PACKAGES) <= set(ros2(installed, folder, 'pkg', 'list').split())


def test_in_its_own_workspace_the_installed_one_counts(installed: Path) -> None:
    printed = ros2(installed, installed / 'ws', 'run', 'flat_robot', 'flat_robot_greet')
    assert printed.startswith('hello from')
