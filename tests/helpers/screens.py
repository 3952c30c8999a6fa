"""Commands on a pseudo-terminal: what they write, or what a person sees of it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from select import select
from time import monotonic
from typing import Any

import pytest
from helpers.command_line import executable
from helpers.patience import COMMAND

if sys.platform == 'win32':
    pytest.skip('terminals of POSIX', allow_module_level=True)

import fcntl
import pty
import termios

CTRL_C = b'\x03'


class Screen:
    """A command on a pseudo-terminal of its own, and what it has written there."""

    def __init__(self, process: subprocess.Popen[bytes], master: int, size: tuple[int, int]) -> None:
        import pyte

        self.process = process
        self.text = ''
        """All that was written, with what steers the terminal."""
        self._master: int | None = master
        self._display = pyte.Screen(*size)
        self._stream = pyte.ByteStream(self._display)

    @property
    def seen(self) -> str:
        """The text that a person sees now."""
        return '\n'.join(line.rstrip() for line in self._display.display)

    def expect(self, pattern: str) -> re.Match[str]:
        """Read until a pattern is found in what was written."""
        return self._read_until(pattern, lambda: self.text)

    def sees(self, pattern: str) -> re.Match[str]:
        """Read until a pattern is found on the screen."""
        return self._read_until(pattern, lambda: self.seen)

    def misses(self, pattern: str) -> None:
        """Read until a pattern is no longer found on the screen."""
        self._read_until(rf'\A(?![\s\S]*(?:{pattern}))', lambda: self.seen)

    def _read_until(self, pattern: str, text: Callable[[], str]) -> re.Match[str]:
        end = monotonic() + COMMAND
        while (found := re.search(pattern, text())) is None:
            left = end - monotonic()
            assert left > 0, f'no {pattern!r} in {text()}'
            assert self._master is not None
            if select([self._master], [], [], left)[0]:
                assert self._read() or re.search(pattern, text()), f'ended without {pattern!r}: {text()}'
        return found

    def _read(self) -> bool:
        assert self._master is not None
        try:
            data = os.read(self._master, 65536)
        except OSError:  # the other end is closed
            return False
        self.text += data.decode(errors='replace')
        self._stream.feed(data)
        return True

    def press(self, keys: bytes) -> None:
        """Type something."""
        assert self._master is not None
        os.write(self._master, keys)

    def wait(self) -> int:
        """Wait for the command's end; what it writes meanwhile is read."""
        end = monotonic() + COMMAND
        while self._master is not None and (left := end - monotonic()) > 0:
            if select([self._master], [], [], left)[0] and not self._read():
                break
        return self.process.wait(max(1.0, end - monotonic()))

    def modes(self) -> list[Any]:
        """Return the terminal's settings for keys: echo, lines, signals."""
        assert self._master is not None
        return termios.tcgetattr(self._master)[:4]

    def close(self) -> None:
        """Close the terminal, as a window is closed."""
        if self._master is not None:
            os.close(self._master)
            self._master = None


@contextmanager
def screen(
    env: Mapping[str, str],
    *arguments: str,
    program: str | Path | None = None,
    size: tuple[int, int] = (80, 24),
    ignores_hangup: bool = False,
    **variables: str,
) -> Iterator[Screen]:
    """Run `ros2`, or another program, on a terminal of so many columns and lines."""

    def begin() -> None:
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)  # the session's own terminal, so that ^C becomes SIGINT
        if ignores_hangup:
            signal.signal(signal.SIGHUP, signal.SIG_IGN)

    columns, lines = size
    master, slave = pty.openpty()
    shown = None
    try:
        termios.tcsetwinsize(slave, (lines, columns))
        process = subprocess.Popen(
            [program or executable(), *arguments],
            env={
                **env,
                'TERM': 'xterm',
                'LINES': str(lines),
                'COLUMNS': str(columns),
                **variables,
            },
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
            preexec_fn=begin,  # noqa: PLW1509 - two system calls between fork and exec
        )
        os.close(slave)
        shown = Screen(process, master, size)
        try:
            yield shown
        finally:
            process.kill()
            process.wait()
    finally:
        if shown is not None:
            shown.close()
        else:
            os.close(master)
