"""The state of the running callback: the exclusive groups that it holds, and the executor that runs it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import local
from typing import TYPE_CHECKING, Protocol

from goalwire.places import program_frame

if TYPE_CHECKING:
    from goalwire.execution.ready_queue import CallbackGroup, NodeWorkQueue

held_groups: ContextVar[tuple[CallbackGroup, ...]] = ContextVar('goalwire_held_groups', default=())
"""The exclusive groups that the running callback holds. It is a context variable, so the tasks and threads
that a coroutine callback starts through asyncio see the same groups."""


class Driven(Protocol):
    """An executor that a thread runs: one of rclpy's, or that of a node in an asyncio loop."""

    work_queue: NodeWorkQueue

    def thread_waits_alone(self) -> bool:
        """Tell whether this executor's callbacks cannot run while the calling thread blocks."""

    def add_capacity(self, count: int) -> None:
        """Allow `count` more threads, in place of threads that block in goalwire's calls.

        A negative `count` takes such threads back.
        """


class _Thread(local):
    def __init__(self) -> None:
        self.executors: list[Driven] = []


active_executors = _Thread()
"""The executors that run on this thread, the innermost one last."""


def current_executor() -> Driven | None:
    """Return the executor of the current callback on this thread, or None outside callbacks."""
    executors = active_executors.executors
    return executors[-1] if executors else None


@contextmanager
def add_capacity() -> Iterator[None]:
    """Allow the executor of the running callback one more thread while the calling thread blocks in this
    `with` block.
    """
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
    """Return the exclusive groups that the calling callback holds."""
    return held_groups.get()


def why_it_cannot_answer(work_queue: NodeWorkQueue, group: CallbackGroup | None) -> str | None:
    """Return the reason why a callback of `work_queue` in `group` cannot run while this thread blocks, or
    None.

    To be called before this thread blocks until an entity of the same process has done something.
    """
    if group is not None and group in held_groups.get():
        name, written = _describe_caller()
        return (
            f'its callback cannot run before {name} returns, and {name} waits for its answer, since both are '
            f"in one mutually exclusive callback group: write {written} and in it 'answer = await "
            "client.call_async(request)', or give one of them a callback group of its own, "
            'callback_group=MutuallyExclusiveCallbackGroup()'
        )
    for executor in active_executors.executors:
        if work_queue.queue is executor.work_queue.queue and executor.thread_waits_alone():
            return (
                'its callback needs the very thread that would wait: spin with a MultiThreadedExecutor, '
                'put one of the nodes into another executor, or await call_async()'
            )
    return None


def _describe_caller() -> tuple[str, str]:
    """Return the name of the program's calling function, and its first line rewritten as an `async def`."""
    frame = program_frame(sys._getframe(1))
    code = None if frame is None else frame.f_code
    if code is None or not code.co_name.isidentifier():  # a lambda
        return 'the calling callback', "it as an 'async def'"
    return (
        f'{code.co_name}()',
        f"'async def {code.co_name}({', '.join(code.co_varnames[: code.co_argcount])}):'",
    )
