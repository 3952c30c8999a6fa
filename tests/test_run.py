from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.fresh import clean_environment
from helpers.packages import write_files

PROGRAM = """\
import sys
import importlib.util
from beside import WHERE
print(__name__, sys.argv[1:], WHERE, 'goalwire' in importlib.util.find_spec('rclpy').origin)
"""


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, '-m', 'goalwire.run', *arguments],
        cwd=folder, env=clean_environment(), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A program in a folder of its own, beside a module and another rclpy."""
    files = {'prog.py': PROGRAM, 'beside.py': 'WHERE = "beside"', 'rclpy/__init__.py': ''}
    write_files(tmp_path / 'programs', files)
    return tmp_path / 'programs' / 'prog.py'


def test_a_program_sees_its_arguments_its_folder_and_goalwire_s_rclpy(program: Path, tmp_path: Path) -> None:
    done = run(tmp_path, str(program), '--ros-args', '-r', 'a:=b')
    assert done.stderr == ''
    assert done.stdout == "__main__ ['--ros-args', '-r', 'a:=b'] beside True\n"


def test_a_module_runs_as_with_python_m(program: Path) -> None:
    done = run(program.parent, '-m', 'prog', 'x')
    assert done.stderr == ''
    assert done.stdout == "__main__ ['x'] beside True\n"


def test_child_processes_see_goalwire_s_rclpy_too(tmp_path: Path) -> None:
    child = 'import importlib.util; print("goalwire" in importlib.util.find_spec("rclpy").origin)'
    files = {
        'rclpy/__init__.py': '',
        'parent.py': f'import subprocess, sys\nsubprocess.run([sys.executable, "-c", {child!r}], check=True)',
    }
    write_files(tmp_path, files)
    assert run(tmp_path, 'parent.py').stdout == 'True\n'


def test_the_programs_exit_code_is_handed_on(tmp_path: Path) -> None:
    write_files(tmp_path, {'prog.py': 'raise SystemExit(7)'})
    assert run(tmp_path, 'prog.py').returncode == 7


@pytest.mark.parametrize(
    ('arguments', 'said'), [([], 'usage:'), (['-m'], 'usage:'), (['nope.py'], 'no such file: nope.py')]
)
def test_a_wrong_command_line_is_refused_with_code_2(arguments: list[str], said: str, tmp_path: Path) -> None:
    done = run(tmp_path, *arguments)
    assert done.returncode == 2
    assert said in done.stderr
