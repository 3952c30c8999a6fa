"""Programs that a process which has imported their modules forks, instead of an interpreter for each.

They are processes of their own, with all that a test does to one. An interpreter that starts takes a tenth of
a second to import rclpy, and two seconds to import the console.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import IO, Self

from helpers import fork_server

_OPENED = (
    'action_msgs.msg', 'action_msgs.srv', 'builtin_interfaces.msg', 'goalwire.cdr.type_hash',
    'goalwire.idl.descriptions', 'goalwire.logging.log_file', 'goalwire.transport.dds.native.session',
    'goalwire.transport.dds.session', 'goalwire.transport.dds.settings.session',
    'goalwire.transport.zenoh.context', 'goalwire.transport.zenoh.embedded_router',
    'goalwire.transport.zenoh.native_wire', 'goalwire.transport.zenoh.rendezvous',
    'goalwire.transport.zenoh.session', 'goalwire.zenoh.io.native_session',
    'goalwire.zenoh.io.shared_memory.session_memory', 'goalwire.zenoh.protocol.router_protocol',
    'service_msgs.msg', 'unique_identifier_msgs.msg',
)  # fmt: skip
"""The modules that programs import to open a session and make a node: over half of their processor time."""


class Forked:
    """A program that was forked, with as much of a `subprocess.Popen` as tests use."""

    def __init__(self, pid: int, ended: int, stdin: int | None, stdout: int | None) -> None:
        self.pid = pid
        self.returncode: int | None = None
        self.stdin = None if stdin is None else os.fdopen(stdin, 'wb')
        self.stdout = None if stdout is None else os.fdopen(stdout, 'rb')
        self._ended: IO[str] = os.fdopen(ended)

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the end; return the exit code (negative: the signal). Raises TimeoutExpired."""
        if self.returncode is None:
            if timeout is not None and not select.select([self._ended], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(str(self.pid), timeout)
            with self._ended:
                self.returncode = int(self._ended.read())
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal to the program alone, unless it has ended."""
        if self.returncode is None:
            with suppress(ProcessLookupError):  # it has ended, and its end is not yet told
                os.kill(self.pid, number)

    def kill(self) -> None:
        """End the program at once."""
        self.send_signal(signal.SIGKILL)


class Forker:
    """Asks a server for programs, by a connection to it."""

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        self._one_at_a_time = Lock()

    def start(
        self,
        source: str | Path,
        arguments: Sequence[str],
        *,
        environment: Mapping[str, str],
        folder: Path | None = None,
        streams: tuple[int, int, int] | None = None,
    ) -> Forked:
        """Start a program, a file or its text, with these standard streams.

        Without any it has pipes: `stdin`, and `stdout` for what it prints and complains of.
        """
        request = {
            'file': str(source) if isinstance(source, Path) else '',
            'text': '' if isinstance(source, Path) else textwrap.dedent(source),
            'arguments': list(arguments),
            'folder': str(folder or Path.cwd()),
            'environment': dict(environment),
        }
        if streams is not None:
            return Forked(*self._fork(request, streams), None, None)
        (keyboard, typing), (output, said) = os.pipe(), os.pipe()
        try:
            forked = self._fork(request, (keyboard, said, said))
        except BaseException:
            os.close(typing)
            os.close(output)
            raise
        finally:
            os.close(keyboard)
            os.close(said)
        return Forked(*forked, typing, output)

    def _fork(self, request: Mapping[str, object], streams: tuple[int, int, int]) -> tuple[int, int]:
        """Return a new process's id, and a pipe that brings its exit code."""
        told, tell = os.pipe()
        try:
            with self._one_at_a_time:
                socket.send_fds(self._channel, [json.dumps(request).encode()], [*streams, tell])
                return int(self._channel.recv(32)), told
        except BaseException:
            os.close(told)
            raise
        finally:
            os.close(tell)


class ForkServer(Forker):
    """The process that forks for each program; see fork_server.py.

    It imports `modules`, and what opens sessions on Zenoh and DDS.
    """

    def __init__(self, modules: Sequence[str], environment: Mapping[str, str]) -> None:
        channel, other = socket.socketpair()
        super().__init__(channel)
        command = [sys.executable, str(fork_server.PROGRAM), str(other.fileno()), *_OPENED, *modules]
        settings = {'PYTHONIOENCODING': 'utf-8', 'OPENBLAS_NUM_THREADS': '1'}
        with other:
            # A session of its own: a signal to the tests' process group must not end it before it has ended
            # its programs.
            self._process = subprocess.Popen(
                command,
                pass_fds=[other.fileno()],
                env={**environment, **settings},
                start_new_session=True,
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the server, which kills the programs that still run."""
        self._channel.close()
        self._process.wait()


def server_of_this_program() -> Forker:
    """In a forked program: connect to the server that forked it, which then forks programs for this one."""
    channel = socket.socket(socket.AF_UNIX)
    channel.connect(fork_server.address(os.getppid()))
    return Forker(channel)
