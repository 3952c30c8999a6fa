"""What the running callback holds: its callback groups and its executor."""

from __future__ import annotations

from contextvars import ContextVar
from threading import local
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.node_work_queue import NodeWorkQueue

held_groups: ContextVar[tuple[CallbackGroup, ...]] = ContextVar('goalwire_held_groups', default=())
"""The exclusive groups that the running callback holds. asyncio hands it on to the tasks and threads that a
coroutine callback starts and may wait for."""


class Driven(Protocol):
    """What a thread drives: an executor, or an asyncio loop's share in a node."""

    work_queue: NodeWorkQueue

    def thread_waits_alone(self) -> bool:
        """Whether nothing of it runs while the calling thread blocks."""

    def add_capacity(self, count: int) -> None:
        """Make up for `count` threads that block in a call of ours; negative: they are back."""


class _Thread(local):
    def __init__(self) -> None:
        self.executors: list[Driven] = []


active_executors = _Thread()
"""What this thread drives, the innermost one last."""


def current_group() -> CallbackGroup | None:
    """The exclusive group of the running callback, or None outside one and in reentrant groups."""
    held = held_groups.get()
    return held[-1] if held else None


def current_executor() -> Driven | None:
    """What runs the current callback on this thread, or None outside callbacks."""
    executors = active_executors.executors
    return executors[-1] if executors else None
