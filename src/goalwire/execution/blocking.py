"""Blocking calls (execution rule 3): they wait on their own thread and need no executor."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from goalwire.execution.current import active_executors, current_executor, current_group, held_groups

if TYPE_CHECKING:
    from collections.abc import Iterator

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.clock import Clock
    from goalwire.execution.future import Future
    from goalwire.execution.node_work_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal

__all__ = [
    'abandon',
    'block_on',
    'block_on_clock',
    'capacity_added',
    'current_executor',
    'current_group',
    'current_groups',
    'why_it_cannot_answer',
]


def block_on(future: Future[Any], deadline: int | None, shutdown_signal: ShutdownSignal) -> bool:
    """Block until `future` is settled (True); False at `deadline` (steady ns) or the shutdown."""
    executors = active_executors.executors
    if not executors:
        return future.wait(deadline, clock=shutdown_signal.clock, shutdown_signal=shutdown_signal)
    if future.settled():
        return True
    executor = executors[-1]
    executor.add_capacity(1)
    try:
        return future.wait(deadline, clock=shutdown_signal.clock, shutdown_signal=shutdown_signal)
    finally:
        executor.add_capacity(-1)


def abandon(future: Future[Any]) -> None:
    """Give it up where blocking on it was interrupted: nobody will ask how it ended, or ends."""
    future.cancel()
    future.exception()


def block_on_clock(future: Future[Any], clock: Clock, until_ns: int, shutdown_signal: ShutdownSignal) -> bool:
    """Block until `future` is settled (True); False when `clock` shows `until_ns`, or at the shutdown.

    A switch between system and simulated time ends it, too: `until_ns` means nothing then.
    """
    waiter = shutdown_signal.new_waiter()
    is_over = clock.has_passed(until_ns - clock.now_ns())
    future.add_waker(waiter.wake)
    try:
        with capacity_added():
            clock.wait_until(until_ns, waiter, shutdown_signal, lambda: future.settled() or is_over())
        return future.settled()
    finally:
        future.remove_waker(waiter.wake)


@contextmanager
def capacity_added() -> Iterator[None]:
    """Give the executor of the calling callback a thread more, while this one waits for others."""
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
    """Why a callback of `work_queue` in `group` cannot run while this thread blocks; None where it can.

    To be asked before blocking on something that an entity of this very process has to do.
    """
    if group is not None and group in held_groups.get():
        return (
            'its callback is in the mutually exclusive callback group that the calling callback holds: '
            'give one of them a group of its own, or await call_async()'
        )
    for executor in active_executors.executors:
        if work_queue.queue is executor.work_queue.queue and executor.thread_waits_alone():
            return (
                'its callback needs the very thread that would wait: spin with a MultiThreadedExecutor, '
                'put one of the nodes into another executor, or await call_async()'
            )
    return None
