"""Keys of a terminal, one by one, for programs that drive a robot by them."""

from __future__ import annotations

import os
import signal
import sys
import termios
import tty
from collections.abc import Iterator

_ESCAPE = '\x1b'
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


def read_keys() -> Iterator[str]:
    """Yield each key: a character, or the three characters of an arrow key, until the input ends.

    The terminal is left as it was, however the loop over the keys ends.
    """
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        while (key := _read(descriptor)) not in _ENDS:
            if key == _ESCAPE:
                key += _read(descriptor) + _read(descriptor)
            yield key
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _read(descriptor: int) -> str:
    try:
        return os.read(descriptor, 1).decode('latin-1')
    except OSError:  # the terminal is gone
        return ''
