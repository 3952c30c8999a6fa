"""The command line as a process: what it prints, what it complains of, how it ends."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import TypeAlias

import pytest
from helpers.forking import ForkServer
from helpers.patience import COMMAND
from helpers.processes import Program
from helpers.wires import DDS

Begin: TypeAlias = Callable[..., Program]
"""`begin(*arguments)` starts a command that goes on; what it prints and complains of is one stream."""

on_dds_too = pytest.mark.parametrize('world', ['rmw_zenoh_cpp', DDS], indirect=True, scope='module')
"""Marks a command's test that each run makes on both wires: it shows that what the command reads is there."""


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
        """The lines that the command printed."""
        return self.out.splitlines()


@dataclass(frozen=True)
class CommandLine:
    """`ros2` in a world."""

    env: Mapping[str, str]
    cwd: Path | None = None
    server: ForkServer | None = None
    """Forks commands, where the start of an interpreter is not what is tested."""

    def __call__(
        self,
        *arguments: str,
        stdin: str = '',
        program: str = 'ros2',
        **variables: str,
    ) -> Ended:
        """Run a command to its end."""
        environment = {**self.env, 'PYTHONIOENCODING': 'utf-8', **variables}
        if self.server is not None:
            ended = self._forked(self.server, executable(program), arguments, environment, stdin)
        else:
            done = subprocess.run(
                [executable(program), *arguments],
                env=environment,
                cwd=self.cwd,
                input=stdin,
                capture_output=True,
                text=True,
                encoding='utf-8',
                timeout=COMMAND,
                check=False,
            )
            ended = Ended(done.returncode, done.stdout, done.stderr)
        assert 'Traceback' not in ended.err, ended.err
        return ended

    def _forked(
        self,
        server: ForkServer,
        program: Path,
        arguments: tuple[str, ...],
        environment: Mapping[str, str],
        stdin: str,
    ) -> Ended:
        with TemporaryFile() as typed, TemporaryFile() as printed, TemporaryFile() as complained:
            typed.write(stdin.encode())
            typed.seek(0)
            streams = (typed.fileno(), printed.fileno(), complained.fileno())
            forked = server.start(
                program, arguments, environment=environment, folder=self.cwd, streams=streams
            )
            try:
                code = forked.wait(COMMAND)
            except subprocess.TimeoutExpired:
                forked.kill()
                forked.wait()
                raise
            printed.seek(0)
            complained.seek(0)
            return Ended(code, printed.read().decode(), complained.read().decode())

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
