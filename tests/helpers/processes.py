"""Python programs as processes of their own, watched without polling."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Self

from helpers.forking import Forked, ForkServer
from helpers.patience import PATIENCE


class Program:
    """A running Python program: `source` is a file (Path) or the program's text (str).

    `env` is its whole environment (see helpers.isolation), by default this process's own; `python` is the
    interpreter, by default the one that runs the tests; a `server` forks the program instead.
    Output and errors arrive as one stream of lines. The program leads its own process group; whatever is left
    of that group when the block ends is killed.
    """

    def __init__(
        self,
        source: str | Path,
        *arguments: str,
        env: Mapping[str, str] | None = None,
        cwd: Path | None = None,
        python: Path = Path(sys.executable),
        server: ForkServer | None = None,
    ) -> None:
        self._title = ' '.join([str(source) if isinstance(source, Path) else 'the program', *arguments])
        environment = {
            **(os.environ if env is None else env),
            'PYTHONUNBUFFERED': '1',
            'PYTHONIOENCODING': 'utf-8',
        }
        self._process: subprocess.Popen[bytes] | Forked
        if server is None:
            code = [str(source)] if isinstance(source, Path) else ['-c', textwrap.dedent(source)]
            self._process = subprocess.Popen(
                [python, *code, *arguments],
                env=environment,
                cwd=cwd,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        else:
            self._process = server.start(source, arguments, environment=environment, folder=cwd)
        self._lines: list[str] = []
        self._next = 0
        self._at_end = False
        self._is_closed = False
        self._changed = threading.Condition()
        self._ended = threading.Event()
        self._reader = threading.Thread(target=self._read, name='program-reader')
        self._reaper = threading.Thread(target=self._reap, name='program-reaper')
        self._reader.start()
        self._reaper.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._changed:
                self._lines.append(line.decode(errors='replace').rstrip('\r\n'))
                self._changed.notify_all()
        with self._changed:
            self._at_end = True
            self._changed.notify_all()

    def _reap(self) -> None:
        # subprocess itself polls where a time limit is given; a blocking wait on a thread does not.
        self._code = self._process.wait()
        self._ended.set()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    @property
    def output(self) -> str:
        """Everything written so far."""
        with self._changed:
            return '\n'.join(self._lines)

    def expect(self, pattern: str, timeout: float = PATIENCE) -> re.Match[str]:
        """Wait for a line that `pattern` is found in, after the line that the last call returned."""
        wanted = re.compile(pattern)
        with self._changed:
            self._changed.wait_for(lambda: self._find(wanted) is not None or self._at_end, timeout)
            found = self._find(wanted)
            if found is not None:
                self._next, match = found
                return match
            how = 'ended without' if self._at_end else f'ran for {timeout} s without'
        raise AssertionError(f'{self._title} {how} a line matching {pattern!r}\n{self._report()}')

    def expect_each(self, *patterns: str, timeout: float = PATIENCE) -> None:
        """Wait for a line for each pattern, in any order, after the line that the last call returned."""
        start, last = self._next, self._next
        deadline = monotonic() + timeout
        for pattern in patterns:
            self._next = start
            self.expect(pattern, max(0.0, deadline - monotonic()))
            last = max(last, self._next)
        self._next = last

    def _find(self, wanted: re.Pattern[str]) -> tuple[int, re.Match[str]] | None:
        for number in range(self._next, len(self._lines)):
            if match := wanted.search(self._lines[number]):
                return number + 1, match
        return None

    def write_line(self, text: str) -> None:
        """Send one line to the program's standard input."""
        assert self._process.stdin is not None
        self._process.stdin.write(f'{text}\n'.encode())
        self._process.stdin.flush()

    def send_signal(self, number: int) -> None:
        """Send a signal to the program alone."""
        self._process.send_signal(number)

    def kill(self) -> None:
        """End the program at once, as kill -9 does."""
        self._process.kill()

    def wait(self, timeout: float = PATIENCE) -> int:
        """Wait for the end and return the exit code (negative: the signal); the output is then complete."""
        if not self._ended.wait(timeout):
            raise AssertionError(f'{self._title} did not end within {timeout} s\n{self._report()}')
        self._reader.join(timeout)
        return self._code

    def succeed(self, timeout: float = PATIENCE) -> str:
        """Wait for the end, insist on exit code 0 and return the output."""
        code = self.wait(timeout)
        assert code == 0, f'{self._title} ended with code {code}\n{self._report()}'
        return self.output

    def _report(self) -> str:
        return f'--- its output, exit code {self._process.returncode}:\n' + '\n'.join(self._lines)

    def close(self) -> None:
        """Kill what still runs of the program and its children, and collect it. Idempotent.

        Close a program that has ended soon: its process id, and so the id of its group, may be given to
        another program, which would be killed.
        """
        if self._is_closed:
            return
        self._is_closed = True
        self._kill_group()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        self._reaper.join()
        self._reader.join()
        self._process.stdout.close()

    def _kill_group(self) -> None:
        if sys.platform == 'win32':
            self._process.kill()
            return
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
