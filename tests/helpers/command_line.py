"""The command line as a process: what it prints, what it complains of, how it ends."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from helpers.patience import COMMAND
from helpers.processes import Program

Begin: TypeAlias = Callable[..., Program]
"""`begin(*arguments)` starts a command that goes on; what it prints and complains of is one stream."""


def executable(name: str = 'ros2') -> Path:
    """The installed program."""
    return Path(sys.executable).with_name(f'{name}.exe' if sys.platform == 'win32' else name)


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        """What it printed, line by line."""
        return self.out.splitlines()


@dataclass(frozen=True)
class CommandLine:
    """`ros2` in a world."""

    env: Mapping[str, str]
    cwd: Path | None = None

    def __call__(
        self,
        *arguments: str,
        stdin: str = '',
        program: str = 'ros2',
        **variables: str,
    ) -> Ended:
        """Run a command to its end."""
        done = subprocess.run(
            [executable(program), *arguments],
            env={**self.env, 'PYTHONIOENCODING': 'utf-8', **variables},
            cwd=self.cwd,
            input=stdin,
            capture_output=True,
            text=True,
            encoding='utf-8',
            timeout=COMMAND,
            check=False,
        )
        assert 'Traceback' not in done.stderr, done.stderr
        return Ended(done.returncode, done.stdout, done.stderr)

    def ok(self, *arguments: str, stdin: str = '', program: str = 'ros2', **variables: str) -> str:
        """Run a command that succeeds without a complaint; what it prints."""
        ended = self(*arguments, stdin=stdin, program=program, **variables)
        assert (ended.code, ended.err) == (0, ''), f'{arguments}: {ended}'
        return ended.out

    def fails(self, *arguments: str, code: int, stdin: str = '', **variables: str) -> str:
        """Run a command that fails with one line, which is returned."""
        ended = self(*arguments, stdin=stdin, **variables)
        assert ended.code == code, f'{arguments}: {ended}'
        assert ended.err.count('\n') == 1, f'{arguments}: {ended}'
        return ended.err.rstrip('\n')
