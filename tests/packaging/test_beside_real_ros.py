"""Beside the real rclpy that PyPI carries (Python 3.11, Linux x86-64), whichever was installed first."""

from __future__ import annotations

import base64
import csv
import hashlib
import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers import real_rclpy
from helpers.environments import CannotInstall, Environment, kept_for_all, made_once
from helpers.fresh import output_of
from helpers.packages import write_files

REAL = ['ros-rclpy[fastrtps]', 'ros-std-srvs', 'ros-geometry-msgs']

pytestmark = [
    pytest.mark.slow,
    pytest.mark.long,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not real_rclpy.EXISTS, reason=real_rclpy.WHY_NOT),
]

PROGRAM = """\
import rclpy
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String
data = serialize_message(String(data='hello'))
print('goalwire' in rclpy.__file__, String.__module__, data.hex(), deserialize_message(data, String).data)
"""
HELLO = '00010000' + '06000000' + b'hello'.hex() + '00'


@contextmanager
def needs_pypi() -> Iterator[None]:
    """Skip where PyPI cannot be reached; what fails for any other reason fails."""
    try:
        yield
    except CannotInstall as error:
        if not error.unreachable:
            raise
        pytest.skip(f'PyPI cannot be reached: {error}')


def damaged(site: Path) -> list[str]:
    """Files that differ from what the RECORD of their distribution says."""
    return [name for name, wanted in _recorded(site) if wanted and wanted != _digest(site / name)]


def claimed_twice_by_us(site: Path) -> list[str]:
    """Files of goalwire that another distribution claims too."""
    ours = {row[0] for row in _rows(next(site.glob('goalwire-*.dist-info')))}
    claims = Counter(name for name, _ in _recorded(site))
    return sorted(name for name in ours if claims[name] > 1)


def _recorded(site: Path) -> list[tuple[str, str]]:
    return [(row[0], row[1]) for info in site.glob('*.dist-info') for row in _rows(info)]


def _rows(info: Path) -> list[list[str]]:
    with (info / 'RECORD').open(newline='', encoding='utf-8') as lines:
        return list(csv.reader(lines))


def _digest(file: Path) -> str:
    digest = hashlib.sha256(file.read_bytes()).digest()
    return 'sha256=' + base64.urlsafe_b64encode(digest).rstrip(b'=').decode()


@pytest.fixture(scope='module', params=['real first', 'goalwire first'])
def both(
    request: pytest.FixtureRequest,
    pytestconfig: pytest.Config,
    tmp_path_factory: pytest.TempPathFactory,
    wheel: Path,
) -> Environment:
    """An environment with both, installed in either order."""

    def install_both(folder: Path) -> None:
        if request.param == 'real first':  # one with the real rclpy is there already, and copied
            kept = kept_for_all(pytestconfig.cache, *real_rclpy.WHEELS)
            shutil.copytree(kept.folder, folder, symlinks=True, dirs_exist_ok=True)
            environment = Environment(folder)
        else:
            environment = Environment.create(folder)
        done = environment.install('--no-compile', str(wheel))
        assert done.returncode == 0, done.stderr
        if request.param == 'goalwire first':
            environment.require('--no-compile', *REAL)

    # "goalwire" in the folder's name would be in the path of every file.
    name = 'ours-second' if request.param == 'real first' else 'ours-first'
    with needs_pypi():
        return Environment(made_once(tmp_path_factory, name, install_both))


def test_no_file_is_overwritten_or_claimed_twice(both: Environment) -> None:
    assert damaged(both.site) == []
    assert claimed_twice_by_us(both.site) == []


def test_the_real_rclpy_and_its_messages_win(both: Environment, tmp_path: Path) -> None:
    ours, module, data, text = output_of(PROGRAM, cwd=tmp_path, python=both.python).split()
    assert (ours, module, text) == ('False', 'std_msgs.msg._string', 'hello')
    assert data.startswith(HELLO)


def test_the_hook_serves_nothing_of_its_own(both: Environment, tmp_path: Path) -> None:
    program = """\
        import importlib.util
        print(importlib.util.find_spec('nav_msgs'), importlib.util.find_spec('std_msgs').origin)
    """
    shown = output_of(program, cwd=tmp_path, python=both.python)
    assert shown == f'None {both.site / "std_msgs" / "__init__.py"}'


def test_goalwire_run_puts_ours_first_and_takes_the_real_messages(both: Environment, tmp_path: Path) -> None:
    program = (
        PROGRAM + 'import nav_msgs.msg, std_msgs\nprint(nav_msgs.msg.__spec__.origin, std_msgs.__file__)'
    )
    write_files(tmp_path, {'prog.py': program})
    start = 'from goalwire.run import main; main(["prog.py"])'
    first, second = output_of(start, cwd=tmp_path, python=both.python).splitlines()
    ours, module, data, text = first.split()
    assert (ours, module, text) == ('True', 'std_msgs.msg._string', 'hello')
    assert data.startswith(HELLO)
    assert second.split() == [
        str(both.site / 'goalwire' / 'idl' / 'share' / 'nav_msgs'),
        str(both.site / 'std_msgs' / '__init__.py'),
    ]


def test_doctor_names_the_real_rclpy(both: Environment, tmp_path: Path) -> None:
    program = 'from goalwire.apps.cli.commands.doctor.installation import check_rclpy; print(*check_rclpy())'
    shown = output_of(program, cwd=tmp_path, python=both.python)
    assert shown.startswith(f'rclpy True `import rclpy` takes the one in {both.site / "rclpy"}, ')
