"""Has a supervisor of the robot get its children forked; imported by the programs of helpers.robot alone."""

from __future__ import annotations

import io
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

from helpers.forking import Forker, server_of_this_program
from humanoid import supervisor

_MAIN = """
from humanoid.cli import main
raise SystemExit(main())
"""


class _Child:
    """As much of a `subprocess.Popen` as `humanoid.supervisor` uses."""

    def __init__(self, server: Forker, arguments: Sequence[str], environment: Mapping[str, str]) -> None:
        self._forked = server.start(_MAIN, arguments, environment=environment, folder=Path.cwd())
        assert self._forked.stdout is not None
        self.pid = self._forked.pid
        self.stdin: IO[bytes] | None = self._forked.stdin
        self.stdout = io.TextIOWrapper(self._forked.stdout, encoding='utf-8', errors='replace')

    def wait(self) -> int:
        return self._forked.wait()

    def terminate(self) -> None:
        self._forked.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self._forked.kill()


class _Subprocess:
    """The substitute for the module `subprocess` in `humanoid.supervisor`: the same, with another Popen."""

    PIPE = subprocess.PIPE
    STDOUT = subprocess.STDOUT

    def __init__(self) -> None:
        self._server: Forker | None = None

    def Popen(
        self, command: Sequence[str], *, env: Mapping[str, str], **settings: object
    ) -> _Child | subprocess.Popen[str]:
        own = [sys.executable, '-m', 'humanoid']
        if list(command[: len(own)]) != own:
            return subprocess.Popen(command, env=env, **settings)  # type: ignore[call-overload,no-any-return]
        if self._server is None:
            self._server = server_of_this_program()
        return _Child(self._server, command[len(own) :], env)


def fork_them() -> None:
    """Have this program's supervisor ask the server that forked it for the robot's own programs."""
    vars(supervisor)['subprocess'] = _Subprocess()
