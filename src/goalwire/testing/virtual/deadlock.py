"""What to say when every thread waits and nothing will ever end that."""

from __future__ import annotations

import sys
import traceback
from typing import TYPE_CHECKING, Any

from goalwire.errors import LocalError

if TYPE_CHECKING:
    from collections.abc import Iterable
    from threading import Thread
    from types import FrameType

_FRAMES = 3
"""Of each thread: the innermost ones of the program, and what they wait in."""


class DeadlockError(LocalError):
    """In virtual time every thread waits, without a deadline, for what only another one could do."""


def describe(waiting: Iterable[Thread], here: Thread) -> str:
    """Say who waits where: threads, and coroutines in asyncio loops."""
    frames = sys._current_frames()  # noqa: SLF001 - public in all but name, says its documentation
    lines = ['everything waits and nothing is due, so no wait would ever end:']
    for thread in [here, *waiting]:
        frame = frames.get(thread.ident or 0)
        lines.append(f"  thread '{thread.name}' waits{_where(frame)}")
    lines += [f"  coroutine '{name}' waits{_where(frame)}" for name, frame in _coroutines()]
    lines.append('give the wait a timeout, or let something end it')
    return '\n'.join(lines)


def describe_stall(running: Iterable[Thread], seconds: float) -> str:
    """Say which threads keep the others waiting, and where they are."""
    frames = sys._current_frames()  # noqa: SLF001
    lines = [
        f'virtual time has stood still for {seconds:g} s of real time, since somebody is busy elsewhere:'
    ]
    lines += [f"  thread '{thread.name}' is at{_where(frames.get(thread.ident or 0))}" for thread in running]
    lines.append(
        'it blocks in the real world (a socket, a process, a lock made before the clock), or computes'
    )
    return '\n'.join(lines)


def _where(frame: FrameType | None) -> str:
    if frame is None:
        return ', not yet begun'
    entries = traceback.extract_stack(frame)
    own = [entry for entry in entries if not _is_machinery(entry.filename)] or entries
    return ''.join(f'\n    {entry.filename}:{entry.lineno} in {entry.name}' for entry in own[-_FRAMES:][::-1])


def _is_machinery(path: str) -> bool:
    path = path.replace('\\', '/')
    return '/goalwire/' in path or '/pytest' in path or '/lib/python' in path or path.startswith('<')


def _coroutines() -> list[tuple[str, FrameType]]:
    """The asyncio tasks that have begun and wait, wherever their loop is."""
    asyncio = sys.modules.get('asyncio')
    if asyncio is None:
        return []
    import gc

    found: list[tuple[str, FrameType]] = []
    tasks: list[Any] = [each for each in gc.get_objects() if isinstance(each, asyncio.Task)]
    for task in tasks:
        stack = [] if task.done() else task.get_stack()
        if stack:
            found.append((task.get_coro().__qualname__, stack[-1]))
    return found
