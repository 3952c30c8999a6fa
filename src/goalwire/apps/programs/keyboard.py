"""Keys of a terminal, one by one, for programs that drive a robot by them."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from select import select

UP, DOWN, RIGHT, LEFT = '\x1b[A', '\x1b[B', '\x1b[C', '\x1b[D'
_ESCAPE = '\x1b'
_REST_S = 0.05
"""How long the rest of an arrow key may take; the Escape key by itself has no rest."""
_ENDS = {'', '\x03', '\x04'}
"""The end of the input, Ctrl-C and Ctrl-D as characters."""


def is_terminal(program: str) -> bool:
    """Say whether there are keys to read; print an error for this program if not."""
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
    """Give the keys as they are pressed: characters, and arrow keys as three each, until the input ends.

    The terminal is left as it was. Keys that are pressed before the block begins are not read.
    """
    descriptor = sys.stdin.fileno()
    with single_keys(descriptor):
        yield _keys(descriptor)


@contextmanager
def single_keys(descriptor: int) -> Iterator[None]:
    """Have a terminal give each key at once and show none while the block runs; then it is as it was."""
    import termios  # not there on Windows
    import tty

    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def split_keys(typed: str) -> list[str]:
    """Split what was typed into keys: characters, and arrow keys as three each."""
    return re.findall(r'\x1b\[.?|.', typed, re.DOTALL)


def _keys(descriptor: int) -> Iterator[str]:
    while (key := _read(descriptor)) not in _ENDS:
        while key[0] == _ESCAPE and len(key) < 3 and select([descriptor], [], [], _REST_S)[0]:
            key += _read(descriptor) or _ESCAPE
        yield key


def _read(descriptor: int) -> str:
    try:
        return os.read(descriptor, 1).decode('latin-1')
    except OSError:  # the terminal is gone
        return ''
