"""Keys on a terminal that control a player."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from goalwire.apps.programs.keyboard import single_keys, split_keys


@contextmanager
def keys(pressed: Callable[[str], None]) -> Iterator[bool]:
    """Call `pressed` with each key while the block runs; yield False if there is no terminal."""
    if sys.platform == 'win32' or not sys.stdin.isatty():
        yield False
        return
    descriptor = sys.stdin.fileno()
    loop = asyncio.get_running_loop()

    def read() -> None:
        typed = os.read(descriptor, 64).decode('utf-8', 'replace')
        if not typed:  # The terminal was closed.
            loop.remove_reader(descriptor)
        for key in split_keys(typed):
            pressed(key)

    with single_keys(descriptor):
        loop.add_reader(descriptor, read)
        try:
            yield True
        finally:
            loop.remove_reader(descriptor)
