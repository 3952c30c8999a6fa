"""What the running callback holds: its callback groups and its executor."""

from __future__ import annotations

from contextvars import ContextVar
from threading import local
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.executor import Executor

HELD: ContextVar[tuple[CallbackGroup, ...]] = ContextVar('goalwire_held_groups', default=())
"""The exclusive groups that the running callback holds. asyncio hands it on to the tasks and threads that a
coroutine callback starts and may wait for."""


class _Thread(local):
    def __init__(self) -> None:
        self.executors: list[Executor] = []


THREAD = _Thread()
"""The executors that this thread drives, the innermost one last."""


def current_group() -> CallbackGroup | None:
    """The exclusive group of the running callback, or None outside one and in reentrant groups."""
    held = HELD.get()
    return held[-1] if held else None


def current_executor() -> Executor | None:
    """The executor that runs the current callback on this thread, or None outside callbacks."""
    executors = THREAD.executors
    return executors[-1] if executors else None
