"""Runs programs as child processes: starts them, reads their output, and ends all of them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from types import FrameType, TracebackType
from typing import Self

from humanoid import lifeline

STOP_WITHIN = 5.0  # s for a child process to end after SIGTERM; then it is killed
TAIL = 20  # lines of each child's output that are kept to explain a failure


@dataclass(frozen=True)
class Printed:
    name: str
    line: str


@dataclass(frozen=True)
class Ended:
    name: str
    pid: int
    returncode: int

    def __str__(self) -> str:
        return f'{self.name} (pid {self.pid}) {ending(self.returncode)}'


@dataclass(frozen=True)
class StopAsked:
    """Ctrl-C or SIGTERM reached the supervisor."""

    signal: int


Event = Printed | Ended | StopAsked


@dataclass
class Child:
    name: str
    process: subprocess.Popen[str]
    tail: deque[str] = field(default_factory=lambda: deque(maxlen=TAIL))
    done: threading.Event = field(default_factory=threading.Event)


class Supervisor:
    """Runs child processes. A context manager: leaving the block, also by an exception, stops every child.

    A child does not receive the terminal's Ctrl-C, since it has a process group of its own; SIGTERM stops it.
    If the supervisor itself is killed, its children's lifelines close, and the children end. After Ctrl-C or
    SIGTERM these signals stay ignored after the block, so that the program can end in order.
    """

    def __init__(self) -> None:
        self._children: list[Child] = []
        self._events: SimpleQueue[Event] = SimpleQueue()
        self._handlers: dict[signal.Signals, Callable[[int, FrameType | None], object] | int | None] = {}
        self._asked = False

    def __enter__(self) -> Self:
        for number in (signal.SIGINT, signal.SIGTERM):
            self._handlers[number] = signal.signal(number, self._on_stop)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()
        for number, handler in self._handlers.items():
            signal.signal(number, signal.SIG_IGN if self._asked else handler)

    def start(self, name: str, command: Sequence[str]) -> int:
        """Start `command` as a child process, called `name` in events, and return its pid."""
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding='utf-8',
            errors='replace',
            env={**os.environ, lifeline.VARIABLE: '1', 'PYTHONUNBUFFERED': '1', 'PYTHONIOENCODING': 'utf-8'},
            start_new_session=os.name == 'posix',
            creationflags=getattr(subprocess, 'CREATE_NEW_PROCESS_GROUP', 0),
        )
        child = Child(name, process)
        self._children.append(child)
        threading.Thread(target=self._listen, args=[child], name=f'{name} output', daemon=True).start()
        return process.pid

    def next_event(self, deadline: float | None = None) -> Event | None:
        """Wait for the next event; return None if none has come by `deadline`, a time of time.monotonic()."""
        try:
            left = None if deadline is None else max(deadline - time.monotonic(), 0.0)
            return self._events.get(timeout=left)
        except Empty:
            return None

    def tail(self, name: str) -> Sequence[str]:
        """Return the last lines that a program printed."""
        return [line for child in self._children if child.name == name for line in child.tail]

    def stop(self, *names: str) -> None:
        """Terminate the children of these names, or all if no name is given; kill those that do not end."""
        children = [child for child in self._children if not names or child.name in names]
        for child in children:
            if not child.done.is_set():
                child.process.terminate()
        deadline = time.monotonic() + STOP_WITHIN
        for child in children:
            if not child.done.wait(max(deadline - time.monotonic(), 0.0)):
                child.process.kill()
                child.done.wait(STOP_WITHIN)
            if child.process.stdin is not None:
                child.process.stdin.close()

    def _listen(self, child: Child) -> None:
        stream = child.process.stdout
        assert stream is not None
        with stream:
            for line in stream:
                child.tail.append(line.rstrip('\n'))
                self._events.put(Printed(child.name, line.rstrip('\n')))
        returncode = child.process.wait()
        child.done.set()
        self._events.put(Ended(child.name, child.process.pid, returncode))

    def _on_stop(self, number: int, _frame: FrameType | None) -> None:
        self._asked = True
        self._events.put(StopAsked(number))  # SimpleQueue.put is reentrant, so a signal handler may call it


def program(name: str, *arguments: str) -> Sequence[str]:
    """Return the command line that runs one of the robot's own programs (humanoid.cli)."""
    return [sys.executable, '-m', 'humanoid', name, *arguments]


def ending(returncode: int) -> str:
    """Return in words how a process with this return code ended."""
    if returncode < 0:
        try:
            return f'was killed by {signal.Signals(-returncode).name}'
        except ValueError:
            return f'was killed by signal {-returncode}'
    return f'ended with exit code {returncode}'
