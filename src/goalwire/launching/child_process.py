"""One process that a launch starts, in a process group of its own.

The group serves two purposes. Ctrl-C in the terminal reaches only the launch, which then sends the process
one SIGINT: a second one would interrupt a node that is cleaning up. And a signal to the group also reaches
the processes that the process has started, such as a shell's commands or a debugger's program, so that none
of them stays behind.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

POSIX = os.name == 'posix'
_TO_GROUP = frozenset({'SIGINT', 'SIGTERM', 'SIGKILL', 'SIGQUIT', 'SIGHUP'})
_RECHECKS = (0.0, 0.01, 0.05, 0.2)  # s between checks whether a whole group has ended: nothing reports that


class Child(asyncio.SubprocessProtocol):
    """A running process: its output, its end, and the end of the processes that it has started."""

    def __init__(
        self, on_start: Callable[[Child], None], on_output: Callable[[Child, int, bytes], None]
    ) -> None:
        loop = asyncio.get_running_loop()
        self._on_start = on_start
        self._on_output = on_output
        self._transport: asyncio.SubprocessTransport | None = None
        self._open_streams: set[int] = {1, 2}
        self._terminals: list[asyncio.BaseTransport] = []
        self.exited: asyncio.Future[int] = loop.create_future()
        self.streams_closed: asyncio.Future[None] = loop.create_future()
        self.pid = -1

    # --- called by asyncio

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        if isinstance(transport, asyncio.SubprocessTransport):
            self._transport = transport
            self.pid = transport.get_pid()
            self._on_start(self)  # emits ProcessStarted before any output is read

    def pipe_data_received(self, fd: int, data: bytes) -> None:
        self._on_output(self, fd, data)

    def pipe_connection_lost(self, fd: int, exc: Exception | None) -> None:
        self.on_stream_end(fd)

    def process_exited(self) -> None:
        code = self._transport.get_returncode() if self._transport else None
        if not self.exited.done():
            self.exited.set_result(-1 if code is None else code)

    # --- streams

    def on_stream_end(self, fd: int) -> None:
        """Note that an output stream has ended: all of its writers have closed it."""
        self._open_streams.discard(fd)
        if not self._open_streams and not self.streams_closed.done():
            self.streams_closed.set_result(None)

    def add_terminal(self, transport: asyncio.BaseTransport) -> None:
        self._terminals.append(transport)

    def output(self, fd: int, data: bytes) -> None:
        self._on_output(self, fd, data)

    # --- ending it

    @property
    def returncode(self) -> int | None:
        return self.exited.result() if self.exited.done() else None

    async def wait_for_end(self) -> int:
        """Wait for the process's end and, unless others of its group still run, for the end of its output."""
        code = await asyncio.shield(self.exited)
        if not self.group_alive():
            await asyncio.shield(self.streams_closed)
        return code

    def signal(self, wanted: signal.Signals) -> None:
        """Send a signal. Signals that end processes go to the process group, others only to the process."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if POSIX and wanted.name in _TO_GROUP:
                os.killpg(self.pid, wanted)
            elif not self.exited.done():
                os.kill(self.pid, wanted)

    def group_alive(self) -> bool:
        """Return whether any process of the process group still runs."""
        if not POSIX:
            return not self.exited.done()
        try:
            os.killpg(self.pid, 0)
        except ProcessLookupError:
            return False
        except PermissionError:
            return True
        return not sys.platform.startswith('linux') or _has_members(self.pid)

    async def wait_for_group(self, seconds: float) -> bool:
        """Wait up to `seconds` until the process and its group have ended; return whether they have."""
        deadline = time.monotonic() + seconds
        await asyncio.wait([self.exited], timeout=seconds)
        if not self.exited.done():
            return False
        if not self.group_alive():
            return True
        await asyncio.wait([self.streams_closed], timeout=max(0.0, deadline - time.monotonic()))
        for pause in (*_RECHECKS, max(0.0, deadline - time.monotonic())):
            if not self.group_alive():
                return True
            if time.monotonic() >= deadline:
                break
            await asyncio.sleep(pause)
        return not self.group_alive()

    def close(self) -> None:
        """Close pipes and terminals."""
        for terminal in self._terminals:
            terminal.close()
        if self._transport is not None:
            self._transport.close()
        if not self.streams_closed.done():
            self.streams_closed.set_result(None)


def _has_members(group: int) -> bool:
    """Return whether the group has a process that is not a zombie (Linux)."""
    for name in os.listdir('/proc'):
        if not name.isdecimal():
            continue
        with contextlib.suppress(OSError, ValueError, IndexError):
            with open(f'/proc/{name}/stat', 'rb') as file:
                state, _, own_group = file.read().rpartition(b')')[2].split()[:3]
            if int(own_group) == group and state not in {b'Z', b'X', b'x'}:
                return True
    return False


class _TerminalReader(asyncio.Protocol):
    """Reads a process's output from the pseudo-terminal that the process writes to."""

    def __init__(self, child: Child, fd: int) -> None:
        self._child = child
        self._fd = fd

    def data_received(self, data: bytes) -> None:
        self._child.output(self._fd, data.replace(b'\r\n', b'\n'))

    def connection_lost(self, exc: Exception | None) -> None:
        self._child.on_stream_end(self._fd)


async def start_child(
    cmd: list[str],
    *,
    cwd: str | None,
    env: Mapping[str, str] | None,
    shell: bool,
    emulate_tty: bool,
    on_start: Callable[[Child], None],
    on_output: Callable[[Child, int, bytes], None],
) -> Child:
    """Start a process. Raises OSError, and ValueError for a text with a null character."""
    loop = asyncio.get_running_loop()
    child = Child(on_start, on_output)
    options: dict[str, Any] = {'cwd': cwd, 'env': env, 'stdin': subprocess.PIPE}
    if POSIX:
        options['process_group'] = 0
    else:
        options['creationflags'] = subprocess.CREATE_NEW_PROCESS_GROUP  # type: ignore[attr-defined]
    slaves: list[int] = []
    masters: list[int] = []
    try:
        if emulate_tty and POSIX:
            import pty

            for stream in ('stdout', 'stderr'):
                master, slave = pty.openpty()
                masters.append(master)
                slaves.append(slave)
                options[stream] = slave
        if shell:
            await loop.subprocess_shell(lambda: child, ' '.join(cmd), **options)
        else:
            await loop.subprocess_exec(lambda: child, *cmd, **options)
        for fd, master in zip((1, 2), list(masters), strict=False):
            stream_file = os.fdopen(master, 'rb', 0)
            masters.remove(master)
            transport, _ = await loop.connect_read_pipe(
                lambda fd=fd: _TerminalReader(child, fd),  # type: ignore[misc]
                stream_file,
            )
            child.add_terminal(transport)
    finally:
        for descriptor in (*slaves, *masters):
            os.close(descriptor)
    return child
