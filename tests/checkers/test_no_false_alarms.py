"""Type checkers and linters have nothing to say about programs that are right.

The versions are those of the extra `checkers`.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import indent

import pytest
from helpers.environments import Environment
from helpers.fresh import clean_environment
from helpers.markdown import DOCS, ROOT, blocks

from goalwire.idl.stubs import write_stubs

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(600)]

HERE = f'--python-executable={sys.executable}'
# The programs have no annotations, as those of most users: their bodies are looked at nonetheless.
UNTYPED = (
    '--allow-untyped-defs',
    '--allow-incomplete-defs',
    '--allow-untyped-calls',
    '--disable-error-code=var-annotated',
    '--implicit-reexport',  # programs of the course share their imports
)
CHECKERS = {
    'mypy': (
        'mypy',
        '--strict',
        *UNTYPED,
        '--config-file=',
        '--ignore-missing-imports',
        '--follow-imports=silent',
        HERE,
    ),
    'pylint': ('pylint', '--errors-only'),
    'pyrefly': ('pyrefly', 'check', f'--python-interpreter-path={sys.executable}'),
    'pyright': ('pyright', f'--pythonpath={sys.executable}'),
    'ruff': ('ruff', 'check', '--isolated', '--select=F,B,PLE'),
    'ty': ('ty', 'check', f'--python={sys.prefix}'),
}
OF_TYPES = ('mypy', 'pyrefly', 'pyright', 'ty')
NOT_FOR_RUFF = {'common.py', 'notebook.py'}
"""Programs in a style that ruff refuses: names are taken by a star, and values are shown by naming them."""
NUMERIC = ('daqp', 'mujoco', 'numpy', 'scipy')
"""Packages with types that the checkers disagree about."""
WRONG = 'wrong.py'
"""A program of a tutorial whose request has a field of the wrong type."""


@pytest.fixture(scope='module')
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The examples, the programs of the tutorials and the course, and a node that does everything."""
    folder = tmp_path_factory.mktemp('programs')
    for file in [*(ROOT / 'examples').glob('*.py'), *(ROOT / 'examples' / 'course').glob('*.py')]:
        shutil.copy(file, folder)
    for file in (ROOT / 'examples' / 'asyncio').glob('*.py'):
        shutil.copy(file, folder / f'asyncio_{file.name}')
    for page in [*(DOCS / 'tutorials').glob('*.md'), *(DOCS / 'course').glob('*.md')]:
        for block in blocks(page):
            if block.language == 'python' and block.title and not (folder / block.title).exists():
                (folder / block.title).write_text(block.text, encoding='utf-8')
    code = code_of_notebook(DOCS / 'course' / 'services-and-actions.ipynb')
    (folder / 'notebook.py').write_text(code, encoding='utf-8')
    shutil.copy(Path(__file__).with_name('programs') / 'ordinary_node.py', folder)
    # Beside the programs, as in a workspace: else pyrefly takes its source and its installed copy for two.
    shutil.copytree(ROOT / 'robot' / 'humanoid' / 'humanoid', folder / 'humanoid')
    write_stubs(folder, ['humanoid_interfaces'])
    (folder / 'pyrefly.toml').touch()  # without one pyrefly looks for little
    return folder


@pytest.fixture(scope='module')
def robot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The robot's package, an ordinary ROS 2 package of some size."""
    folder = tmp_path_factory.mktemp('robot')
    shutil.copytree(ROOT / 'robot' / 'humanoid' / 'humanoid', folder / 'humanoid')
    write_stubs(folder, ['humanoid_interfaces'])
    (folder / 'pyrefly.toml').touch()
    return folder


def code_of_notebook(file: Path) -> str:
    """Return a notebook's cells as one coroutine: there they may await, and names go from cell to cell."""
    cells = json.loads(file.read_text(encoding='utf-8'))['cells']
    code = '\n'.join(''.join(cell['source']) for cell in cells if cell['cell_type'] == 'code')
    return f'async def notebook():\n{indent(code, "    ")}\n'


def check(
    environment: Environment, checker: str, folder: Path, *files: str
) -> subprocess.CompletedProcess[str]:
    """Run a checker over programs."""
    tool, *options = CHECKERS[checker]
    return subprocess.run(
        [environment.python.with_name(tool), *options, *files],
        cwd=folder, env=clean_environment(), capture_output=True, text=True, timeout=500, check=False,
    )  # fmt: skip


@pytest.mark.parametrize('checker', CHECKERS)
def test_no_program_is_complained_of(checkers: Environment, programs: Path, checker: str) -> None:
    files = [file for file in sorted(programs.glob('*.py')) if file.name != WRONG]
    if checker == 'ruff':
        shared = 'from common import *'
        files = [file for file in files if file.name not in NOT_FOR_RUFF and shared not in file.read_text()]
    assert len(files) > 30
    done = check(checkers, checker, programs, *(file.name for file in files))
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize('checker', CHECKERS)
def test_the_robot_is_not_complained_of(checkers: Environment, robot: Path, checker: str) -> None:
    files = [
        str(file.relative_to(robot))
        for file in sorted((robot / 'humanoid').rglob('*.py'))
        if 'rclpy' in (text := file.read_text(encoding='utf-8')) and not any(name in text for name in NUMERIC)
    ]
    assert len(files) > 15
    done = check(checkers, checker, robot, *files)
    assert done.returncode == 0, done.stdout[-20_000:] + done.stderr


@pytest.mark.parametrize('checker', OF_TYPES)
def test_a_mistake_in_a_message_is_found(checkers: Environment, programs: Path, checker: str) -> None:
    done = check(checkers, checker, programs, WRONG)
    assert done.returncode == 1
    assert WRONG in done.stdout
