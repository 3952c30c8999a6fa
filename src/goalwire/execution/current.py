"""The state of the running callback: the exclusive groups that it holds, and the executor that runs it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import local
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from goalwire.execution.ready_queue import CallbackGroup, NodeWorkQueue

held_groups: ContextVar[tuple[CallbackGroup, ...]] = ContextVar('goalwire_held_groups', default=())
"""The exclusive groups that the running callback holds. asyncio hands it on to the tasks and threads that a
coroutine callback starts and may wait for."""


class Driven(Protocol):
    """Something that a thread runs: an executor, or a node's part in an asyncio loop."""

    work_queue: NodeWorkQueue

    def thread_waits_alone(self) -> bool:
        """Whether nothing of it runs while the calling thread blocks."""

    def add_capacity(self, count: int) -> None:
        """Make up for `count` threads that block in a call of ours; negative: they are back."""


class _Thread(local):
    def __init__(self) -> None:
        self.executors: list[Driven] = []


active_executors = _Thread()
"""The executors that run on this thread, the innermost one last."""


def current_executor() -> Driven | None:
    """The executor of the current callback on this thread, or None outside callbacks."""
    executors = active_executors.executors
    return executors[-1] if executors else None


@contextmanager
def add_capacity() -> Iterator[None]:
    """Give the executor of the running callback one thread more while this one waits for others."""
    executor = current_executor()
    if executor is None:
        yield
        return
    executor.add_capacity(1)
    try:
        yield
    finally:
        executor.add_capacity(-1)


def current_groups() -> tuple[CallbackGroup, ...]:
    """The exclusive groups that the calling callback holds."""
    return held_groups.get()


def why_it_cannot_answer(work_queue: NodeWorkQueue, group: CallbackGroup | None) -> str | None:
    """Why a callback of `work_queue` in `group` cannot run while this thread blocks; None if it can.

    To be asked before blocking on something that an entity of this very process has to do.
    """
    if group is not None and group in held_groups.get():
        return (
            'its callback cannot run before the calling callback returns, since both are in one mutually '
            "exclusive callback group: write 'async def' and 'await client.call_async(request)', or give one "
            'of them a callback group of its own'
        )
    for executor in active_executors.executors:
        if work_queue.queue is executor.work_queue.queue and executor.thread_waits_alone():
            return (
                'its callback needs the very thread that would wait: spin with a MultiThreadedExecutor, '
                'put one of the nodes into another executor, or await call_async()'
            )
    return None
