"""Reads single keys from a terminal, for programs that drive a robot by keyboard."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from select import select

from goalwire.execution.signals.signal_pipe import SignalPipe, signal_pipe

UP, DOWN, RIGHT, LEFT = '\x1b[A', '\x1b[B', '\x1b[C', '\x1b[D'
_ESCAPE = '\x1b'
_REST_S = 0.05
"""Seconds to wait after an Escape character for the rest of an arrow key's sequence."""
_ENDS = {'', '\x03', '\x04'}
"""The readings that end the keys: '' at the end of the input, Ctrl-C and Ctrl-D."""


def is_terminal(program: str) -> bool:
    """Return True if standard input is a terminal; otherwise print an error and return False."""
    if sys.stdin.isatty():
        return True
    print(f'{program}: it reads keys, and its input is not a terminal', file=sys.stderr)
    return False


def interrupt_on_signals() -> None:
    """Let SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt, so that a stop can still be sent."""
    for ending in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(ending, signal.default_int_handler)


@contextmanager
def keys() -> Iterator[Iterator[str]]:
    """Yield each pressed key until the input ends: a character, or three characters for an arrow key.

    The terminal's mode is restored at the end. Keys that were pressed before the start are not read.
    """
    descriptor = sys.stdin.fileno()
    pipe = signal_pipe()
    with single_keys(descriptor):
        pipe.take()
        try:
            yield _keys(descriptor, pipe)
        finally:
            pipe.give_back()


@contextmanager
def single_keys(descriptor: int) -> Iterator[None]:
    """Set the terminal to single keys without echo while the block runs, then restore its mode."""
    import termios  # missing on Windows
    import tty

    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def split_keys(typed: str) -> list[str]:
    """Split typed characters into keys: single characters, and three characters for an arrow key."""
    return re.findall(r'\x1b\[.?|.', typed, re.DOTALL)


def _keys(descriptor: int, pipe: SignalPipe) -> Iterator[str]:
    while (key := _read(descriptor, pipe)) not in _ENDS:
        while key[0] == _ESCAPE and len(key) < 3 and select([descriptor], [], [], _REST_S)[0]:
            key += _read(descriptor, pipe) or _ESCAPE
        yield key


def _read(descriptor: int, pipe: SignalPipe) -> str:
    """Wait for a character and return it; '' at the end of the input.

    A signal that comes just before a read does not interrupt that read, and Ctrl-C would only count with the
    next key. It writes into the pipe, so this wait ends, and Python calls the signal's handler.
    """
    try:
        while descriptor not in (ready := select([descriptor, pipe.reader], [], [])[0]):
            if pipe.reader in ready:
                pipe.pass_on(os.read(pipe.reader, 64))
        return os.read(descriptor, 1).decode('latin-1')
    except OSError:  # The terminal was closed.
        return ''
