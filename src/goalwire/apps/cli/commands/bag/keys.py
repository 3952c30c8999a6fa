"""Keys on a terminal that steer a player."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

UP, DOWN, RIGHT = '\x1b[A', '\x1b[B', '\x1b[C'


@contextmanager
def keys(pressed: Callable[[str], None]) -> Iterator[bool]:
    """Have `pressed` called with each key while the block runs; yield False if there is no terminal."""
    if sys.platform == 'win32' or not sys.stdin.isatty():
        yield False
        return
    import termios
    import tty

    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    loop = asyncio.get_running_loop()

    def read() -> None:
        typed = os.read(descriptor, 64).decode('utf-8', 'replace')
        if not typed:  # the terminal has gone
            loop.remove_reader(descriptor)
        while typed:
            key = typed[:3] if typed.startswith('\x1b[') else typed[:1]
            typed = typed[len(key) :]
            pressed(key)

    tty.setcbreak(descriptor)
    loop.add_reader(descriptor, read)
    try:
        yield True
    finally:
        loop.remove_reader(descriptor)
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
