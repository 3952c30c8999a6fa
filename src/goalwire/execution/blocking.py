"""Blocking calls (execution rule 3): they wait on their own thread and need no executor."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from goalwire.execution.current import HELD, THREAD, current_executor, current_group

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.clock import Clock
    from goalwire.execution.future import Future
    from goalwire.execution.home import Home
    from goalwire.execution.lifeline import Lifeline

__all__ = [
    'abandon',
    'block_on',
    'block_on_clock',
    'current_executor',
    'current_group',
    'current_groups',
    'thread_lent',
    'why_it_cannot_answer',
]


def block_on(future: Future[Any], deadline: int | None, lifeline: Lifeline) -> bool:
    """Block until `future` is settled (True); False at `deadline` (steady ns) or the lifeline's end."""
    executors = THREAD.executors
    if not executors:
        return future.wait(deadline, clock=lifeline.clock, lifeline=lifeline)
    if future.settled():
        return True
    executor = executors[-1]
    executor.lend_thread(1)
    try:
        return future.wait(deadline, clock=lifeline.clock, lifeline=lifeline)
    finally:
        executor.lend_thread(-1)


def abandon(future: Future[Any]) -> None:
    """Give it up where blocking on it was interrupted: nobody will ask how it ended, or ends."""
    future.cancel()
    future.exception()


def block_on_clock(future: Future[Any], clock: Clock, until_ns: int, lifeline: Lifeline) -> bool:
    """Block until `future` is settled (True); False when `clock` shows `until_ns`, or at the lifeline's end.

    A switch between system and simulated time ends it, too: `until_ns` means nothing then.
    """
    waiter = lifeline.new_waiter()
    is_over = clock.has_passed(until_ns - clock.now_ns())
    future.add_waker(waiter.wake)
    try:
        with thread_lent():
            clock.wait_until(until_ns, waiter, lifeline, lambda: future.settled() or is_over())
        return future.settled()
    finally:
        future.remove_waker(waiter.wake)


@contextmanager
def thread_lent() -> Iterator[None]:
    """Give the executor of the calling callback a thread more, while this one waits for others."""
    executor = current_executor()
    if executor is None:
        yield
        return
    executor.lend_thread(1)
    try:
        yield
    finally:
        executor.lend_thread(-1)


def current_groups() -> tuple[CallbackGroup, ...]:
    """The exclusive groups that the calling callback holds."""
    return HELD.get()


def why_it_cannot_answer(home: Home, group: CallbackGroup | None) -> str | None:
    """Why a callback of `home` in `group` cannot run while the calling thread blocks; None where it can.

    To be asked before blocking on something that an entity of this very process has to do.
    """
    if group is not None and group in HELD.get():
        return (
            'its callback is in the mutually exclusive callback group that the calling callback holds: '
            'give one of them a group of its own, or await call_async()'
        )
    for executor in THREAD.executors:
        if home.queue is executor.home.queue and executor.thread_waits_alone():
            return (
                'its callback needs the very thread that would wait: spin with a MultiThreadedExecutor, '
                'put one of the nodes into another executor, or await call_async()'
            )
    return None
