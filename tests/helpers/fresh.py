"""Fresh Python interpreters: what a program's first line sees."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

from helpers.isolation import BYTECODE, WHOSE_SESSIONS, log_directory

_OURS = ('GOALWIRE_', 'AMENT_', 'PYTHON', 'ROS_')


def clean_environment(**variables: str) -> dict[str, str]:
    """This process's environment without what steers goalwire, ROS or Python, and with `variables`."""
    inherited = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(_OURS) or name in WHOSE_SESSIONS
    }
    if BYTECODE in os.environ:
        inherited[BYTECODE] = os.environ[BYTECODE]
    return {**inherited, 'ROS_LOG_DIR': str(log_directory()), **variables}


def run_python(
    code: str,
    *arguments: str,
    cwd: Path,
    python: Path | None = None,
    options: tuple[str, ...] = (),
    **env: str,
) -> subprocess.CompletedProcess[str]:
    """Run a program's text with `python -c` in folder cwd and return what it wrote; 60 s at most."""
    return subprocess.run(
        [str(python or sys.executable), *options, '-c', textwrap.dedent(code), *arguments],
        cwd=cwd, env=clean_environment(**env), capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


def output_of(
    code: str,
    *arguments: str,
    cwd: Path,
    python: Path | None = None,
    options: tuple[str, ...] = (),
    **env: str,
) -> str:
    """Return the output of a program, stripped; the program must exit with 0."""
    done = run_python(code, *arguments, cwd=cwd, python=python, options=options, **env)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
