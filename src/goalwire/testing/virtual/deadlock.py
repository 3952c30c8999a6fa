"""Makes the error text for the case that all threads wait and nothing in virtual time can wake one."""

from __future__ import annotations

import os
import sys
import sysconfig
from traceback import StackSummary, walk_stack
from typing import TYPE_CHECKING, Any

from goalwire.tracebacks import is_library, is_standard

if TYPE_CHECKING:
    from collections.abc import Iterable
    from threading import Thread
    from types import FrameType

_SHOWN = 3
"""The number of places in the code that are shown for each thread and coroutine."""

_INSTALLED = tuple(sysconfig.get_path(name) + os.sep for name in ('purelib', 'platlib'))
"""The folders of installed packages, such as pytest."""


def describe(waiting: Iterable[Thread], here: Thread) -> str:
    """Return a text that names each waiting thread and coroutine, and where it waits."""
    lines = ['everything waits and nothing is due, so no wait would ever end:']
    lines += [f"  thread '{name}' waits{_show(places)}" for name, places in _threads([here, *waiting])]
    lines += [f"  coroutine '{name}' waits{_show(places)}" for name, places in _coroutines()]
    lines.append('give the wait a timeout, or let something end it')
    return '\n'.join(lines)


def describe_stall(running: Iterable[Thread], seconds: float) -> str:
    """Return a text that names the threads that keep the others waiting, and the places where they are."""
    lines = [
        f'virtual time has stood still for {seconds:g} s of real time, since somebody is busy elsewhere:'
    ]
    lines += [f"  thread '{name}' is at{_show(places)}" for name, places in _threads(running)]
    lines.append(
        'it blocks in the real world (a socket, a process, a lock made before the clock), or computes'
    )
    return '\n'.join(lines)


def _show(places: StackSummary) -> str:
    """Return the innermost places as text; places in goalwire and Python only if there are no others."""
    own = [state for state in places if not _is_machinery(state.filename)] or places
    return ''.join(f'\n    {state.filename}:{state.lineno} in {state.name}' for state in own[-_SHOWN:][::-1])


def _is_machinery(path: str) -> bool:
    """Return True if a file's path is in goalwire, Python or an installed package."""
    return is_library(path) or is_standard(path) or path.startswith((*_INSTALLED, '<'))


def _threads(threads: Iterable[Thread]) -> list[tuple[str, StackSummary]]:
    frames = sys._current_frames()  # Python documents it for such tools
    found = []
    for thread in threads:
        frame = frames.get(thread.ident or 0)
        places = StackSummary() if frame is None else StackSummary.extract(walk_stack(frame))
        places.reverse()
        found.append((thread.name, places))
    return found


def _coroutines() -> list[tuple[str, StackSummary]]:
    """Return the waiting asyncio tasks of all loops, with the coroutines that each awaits."""
    asyncio = sys.modules.get('asyncio')
    if asyncio is None:
        return []
    import gc

    tasks: list[Any] = [each for each in gc.get_objects() if isinstance(each, asyncio.Task)]
    found = []
    for task in tasks:
        frames = [] if task.done() else _frames_of(task.get_coro())
        if frames:
            places = StackSummary.extract((frame, frame.f_lineno) for frame in frames)
            own = [state.name for state in places if not _is_machinery(state.filename)]
            found.append((own[0] if own else places[0].name, places))
    return found


def _frames_of(coroutine: Any) -> list[FrameType]:
    """Return the frames of a coroutine and of the coroutines that it awaits, the outermost first."""
    frames = []
    while frame := getattr(coroutine, 'cr_frame', None):
        frames.append(frame)
        coroutine = coroutine.cr_await
    return frames
