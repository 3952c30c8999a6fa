"""How a thread waits for a transform: it takes what the listeners have heard itself.

Who would do that otherwise may be the very thread that waits: a callback under the single-threaded executor.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rclpy.task import Future

from goalwire.execution.clock import block_on_clock
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.waitable import unwatch, watch

if TYPE_CHECKING:
    from rclpy.clock import Clock

    from goalwire.execution.waiting import ShutdownSignal

__all__ = ['wait_hearing']


class _Arrivals:
    """A future of whatever comes next."""

    def __init__(self) -> None:
        self.next: Future[None] = Future()

    def tell(self) -> None:
        """Something has come. Any thread."""
        self.next.set_result(None)


def wait_hearing(
    future: Future[Any],
    event_queues: Iterable[EventQueue[Any]],
    clock: Clock,
    until_ns: int,
    shutdown_signal: ShutdownSignal,
) -> None:
    """Handle what comes to the event queues until `future` is settled, `clock` shows `until_ns`, or the end.

    Raises what the subscriptions' callbacks raise.
    """
    heard = list(event_queues)
    arrivals = _Arrivals()
    for event_queue in heard:
        watch(event_queue, arrivals.tell)
    future.add_waker(arrivals.tell)
    try:
        while True:
            arrivals.next = Future()  # before looking: what comes from now on completes this one
            for event_queue in heard:
                while future.pending() and (event := event_queue.take()) is not None:
                    event_queue.handle(event)
            if not future.pending() or not block_on_clock(arrivals.next, clock, until_ns, shutdown_signal):
                return
    finally:
        future.remove_waker(arrivals.tell)
        for event_queue in heard:
            unwatch(event_queue, arrivals.tell)
