"""Type checkers and linters have nothing to say about programs that are right.

The versions are those of the extra `checkers`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.environments import Environment
from helpers.fresh import clean_environment
from helpers.markdown import DOCS, ROOT, blocks

from goalwire.idl.stubs import write_stubs

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(600)]

HERE = f'--python-executable={sys.executable}'
# The programs have no annotations, as those of most users: their bodies are looked at nonetheless.
UNTYPED = ('--allow-untyped-defs', '--allow-incomplete-defs', '--allow-untyped-calls')
CHECKERS = {
    'mypy': ('mypy', '--strict', *UNTYPED, '--config-file=', '--disable-error-code=import-untyped', HERE),
    'pylint': ('pylint', '--errors-only'),
    'pyrefly': ('pyrefly', 'check', f'--python-interpreter-path={sys.executable}'),
    'pyright': ('pyright', f'--pythonpath={sys.executable}'),
    'ruff': ('ruff', 'check', '--isolated', '--select=F,B,PLE'),
    'ty': ('ty', 'check', f'--python={sys.prefix}'),
}
OF_TYPES = ('mypy', 'pyrefly', 'pyright', 'ty')
WRONG = 'wrong.py'
"""A program of a tutorial whose request has a field of the wrong type."""


@pytest.fixture(scope='module')
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The examples, those of the course too, the tutorials' programs, and a node that does everything."""
    folder = tmp_path_factory.mktemp('programs')
    for file in [*(ROOT / 'examples').glob('*.py'), *(ROOT / 'examples' / 'course').glob('*.py')]:
        shutil.copy(file, folder)
    for file in (ROOT / 'examples' / 'asyncio').glob('*.py'):
        shutil.copy(file, folder / f'asyncio_{file.name}')
    for page in (DOCS / 'tutorials').glob('*.md'):
        for block in blocks(page):
            if block.language == 'python' and block.title and not (folder / block.title).exists():
                (folder / block.title).write_text(block.text, encoding='utf-8')
    shutil.copy(Path(__file__).with_name('programs') / 'ordinary_node.py', folder)
    write_stubs(folder, ['humanoid_interfaces'])
    (folder / 'pyrefly.toml').touch()  # without one pyrefly looks for little
    return folder


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
    names = sorted(file.name for file in programs.glob('*.py') if file.name != WRONG)
    assert len(names) > 30
    done = check(checkers, checker, programs, *names)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize('checker', OF_TYPES)
def test_a_mistake_in_a_message_is_found(checkers: Environment, programs: Path, checker: str) -> None:
    done = check(checkers, checker, programs, WRONG)
    assert done.returncode == 1
    assert WRONG in done.stdout
