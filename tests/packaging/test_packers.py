"""Where programs go: each tool of docs/how-to/packaging.md, with a program that calls a service."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.environments import CannotInstall, Environment, made_once
from helpers.isolation import isolated_env
from helpers.packages import write_files

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(900)]

PINNED = ['pex==2.105.2', 'pip>=24', 'pipx==1.18.4', 'poetry==2.5.1', 'shiv==1.0.8', 'uv==0.13.9']
PDM = ['hishel==1.4.0', 'pdm==2.29.4']  # PDM 2.29 does not run with hishel 2
PROGRAM = """\
import rclpy
from std_srvs.srv import SetBool


def switch(request, response):
    response.success = request.data
    return response


def main():
    rclpy.init()
    node = rclpy.create_node('lamp')
    node.create_service(SetBool, 'light', switch)
    future = node.create_client(SetBool, 'light').call_async(SetBool.Request(data=True))
    rclpy.spin_until_future_complete(node, future)
    print('light', future.result().success)


if __name__ == '__main__':
    main()
"""
LINE = 'import goalwire.idl.hook\n\ngoalwire.idl.hook.install()\n'
PROJECT = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "lamp"
version = "0.1.0"
requires-python = ">=3.11,<4"
dependencies = ["goalwire"]

[project.scripts]
lamp = "lamp:main"

[tool.hatch.build.targets.wheel]
include = ["lamp.py"]
"""
ROOT_OF_INDEX = 'https://pypi.org/simple/'


def environment_with(pytestconfig: pytest.Config, name: str, *requirements: str) -> Environment:
    """An environment that pytest's cache keeps; skips the test if the package index cannot be reached."""
    assert pytestconfig.cache is not None
    try:
        return Environment.kept(pytestconfig.cache.mkdir('packers') / name, *requirements)
    except CannotInstall as error:
        if not error.unreachable:
            raise
        pytest.skip(f'PyPI cannot be reached: {error}')


@pytest.fixture
def bin_of_tools(pytestconfig: pytest.Config) -> Path:
    """The folder of the tools that get on with each other."""
    return environment_with(pytestconfig, 'tools', *PINNED).python.parent


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """The program, with and without the line, and a pyproject.toml that asks for goalwire."""
    files = {'lamp.py': PROGRAM, 'lamp_with_line.py': LINE + PROGRAM, 'pyproject.toml': PROJECT}
    return write_files(tmp_path / 'project', files)


@pytest.fixture
def world(tmp_path: Path, wheel: Path) -> dict[str, str]:
    """Variables: a graph of its own, a place where goalwire is found, caches that go with the test."""
    return (
        isolated_env('goalwire_memory')
        | {
            'PIP_FIND_LINKS': f'{wheel.parent} {os.environ.get("PIP_FIND_LINKS", "")}',
            'PIPX_BIN_DIR': str(tmp_path / 'bin'),
            'PIPX_HOME': str(tmp_path / 'pipx'),
            'POETRY_VIRTUALENVS_IN_PROJECT': '1',
            'UV_FIND_LINKS': str(wheel.parent),
        }
        | {name: str(tmp_path / name) for name in ('PEX_ROOT', 'SHIV_ROOT', 'POETRY_CACHE_DIR')}
    )


def run(folder: Path, world: dict[str, str], *command: str | Path, fails: bool = False) -> str:
    """Run a command to its end and return what it printed."""
    done = subprocess.run(
        command, cwd=folder, env=world, capture_output=True, text=True, timeout=600, check=False
    )
    assert (done.returncode != 0) is fails, done.stdout + done.stderr
    return done.stderr if fails else done.stdout


@pytest.fixture
def target(
    tmp_path: Path,
    bin_of_tools: Path,
    world: dict[str, str],
    wheel: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """The folder that `pip install --target` makes; it is made once."""

    def install(folder: Path) -> None:
        run(tmp_path, world, bin_of_tools / 'python', '-m', 'pip', 'install', '-q', '--target', folder, wheel)

    return made_once(tmp_path_factory, 'target', install)


def test_a_folder_that_pip_has_filled_needs_the_line(
    project: Path, target: Path, world: dict[str, str], tmp_path: Path
) -> None:
    there = world | {'PYTHONPATH': str(target)}
    bare = Environment.create(tmp_path / 'bare').python
    assert "No module named 'rclpy'" in run(project, there, bare, 'lamp.py', fails=True)
    assert run(project, there, bare, 'lamp_with_line.py') == 'light True\n'
    assert run(project, there, bare, '-S', 'lamp_with_line.py') == 'light True\n'


def test_a_zip_file_is_refused_with_what_to_take(
    project: Path, target: Path, world: dict[str, str], tmp_path: Path
) -> None:
    write_files(target, {'__main__.py': LINE + PROGRAM})
    run(project, world, sys.executable, '-m', 'zipapp', target, '-o', 'lamp.pyz')
    bare = Environment.create(tmp_path / 'bare').python
    told = run(project, world, bare, 'lamp.pyz', fails=True)
    assert told.splitlines()[-1].endswith('take shiv or pex, which unpack themselves')


def test_shiv(project: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path) -> None:
    run(project, world, bin_of_tools / 'shiv', '-q', '-e', 'lamp:main', '-o', 'lamp.pyz', '.', wheel)
    assert run(project, world, './lamp.pyz') == 'light True\n'


@pytest.mark.parametrize('options', [[], ['--venv']], ids=['plain', 'venv'])
def test_pex(
    project: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path, options: list[str]
) -> None:
    run(project, world, bin_of_tools / 'pex', wheel, '-D', '.', *options, '-e', 'lamp:main', '-o', 'lamp.pex')
    assert run(project, world, './lamp.pex') == 'light True\n'


def test_pipx(project: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path) -> None:
    run(project, world, bin_of_tools / 'pipx', 'install', '.')
    assert run(project, world, Path(world['PIPX_BIN_DIR']) / 'lamp') == 'light True\n'
    run(project, world, bin_of_tools / 'pipx', 'install', wheel)
    assert run(project, world, Path(world['PIPX_BIN_DIR']) / 'ros2', 'pkg', 'list')


def test_uv(project: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path) -> None:
    uv = bin_of_tools / 'uv'
    assert (
        run(project, world, uv, 'run', '--no-project', '--with', wheel, 'python', 'lamp.py') == 'light True\n'
    )
    assert run(project, world, uv, 'run', 'lamp') == 'light True\n'


def test_poetry(project: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path) -> None:
    poetry = bin_of_tools / 'poetry'
    (project / 'pyproject.toml').unlink()
    run(project, world, poetry, 'init', '-n', '--name', 'lamp-app', '--python', '>=3.11,<4')
    run(project, world, poetry, 'source', 'add', '--priority=primary', 'index', ROOT_OF_INDEX)
    run(project, world, poetry, 'add', '-n', wheel)
    assert run(project, world, poetry, 'run', 'python', 'lamp.py') == 'light True\n'


def test_pdm(project: Path, pytestconfig: pytest.Config, world: dict[str, str], wheel: Path) -> None:
    pdm = environment_with(pytestconfig, 'pdm', *PDM).python.parent / 'pdm'
    (project / 'pyproject.toml').unlink()
    run(project, world, pdm, 'init', '-n', '--python', sys.executable)
    run(project, world, pdm, 'add', wheel)
    assert run(project, world, pdm, 'run', 'python', 'lamp.py') == 'light True\n'


DISTRIBUTIONS = {
    'setuptools': """\
[build-system]
requires = ["setuptools>=64"]
build-backend = "setuptools.build_meta"

[project]
name = "lamp_interfaces"
version = "0.1.0"

[project.entry-points."goalwire.interfaces"]
lamp_interfaces = "lamp_definitions"

[tool.setuptools]
packages = ["lamp_definitions"]

[tool.setuptools.package-data]
lamp_definitions = ["msg/*.msg", "srv/*.srv", "action/*.action"]
""",
    'hatchling': """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[project]
name = "lamp_interfaces"
version = "0.1.0"

[project.entry-points."goalwire.interfaces"]
lamp_interfaces = "lamp_definitions"

[tool.hatch.build.targets.wheel]
packages = ["lamp_definitions"]
""",
}


@pytest.mark.parametrize('backend', DISTRIBUTIONS)
def test_a_distribution_of_interfaces(
    tmp_path: Path, bin_of_tools: Path, world: dict[str, str], wheel: Path, backend: str
) -> None:
    definitions = {
        'pyproject.toml': DISTRIBUTIONS[backend],
        'lamp_definitions/__init__.py': '',
        'lamp_definitions/srv/SetLight.srv': 'float64 brightness\n---\nbool success\n',
    }
    source = write_files(tmp_path / 'source', definitions)
    empty = tmp_path / 'empty'
    empty.mkdir()
    program = 'from lamp_interfaces.srv import SetLight; print(SetLight.Request(brightness=0.5))'
    both = ('--with', wheel, '--with', source)
    shown = run(empty, world, bin_of_tools / 'uv', 'run', '--no-project', *both, 'python', '-c', program)
    assert shown == 'lamp_interfaces.srv.SetLight_Request(brightness=0.5)\n'
