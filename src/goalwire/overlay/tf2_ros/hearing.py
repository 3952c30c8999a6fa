"""How a thread waits for a transform: it takes what the listeners have heard itself.

Who would do that otherwise may be the very thread that waits: a callback under the single-threaded executor.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from rclpy.task import Future

from goalwire.execution.blocking import block_on_clock
from goalwire.execution.inbox import Inbox
from goalwire.execution.wait_set import unwatch, watch

if TYPE_CHECKING:
    from rclpy.clock import Clock

    from goalwire.execution.lifeline import Lifeline

__all__ = ['wait_hearing']


class _Arrivals:
    """A future of whatever comes next."""

    def __init__(self) -> None:
        self.next: Future[None] = Future()

    def tell(self) -> None:
        """Something has come. Any thread."""
        self.next.set_result(None)


def wait_hearing(
    future: Future[Any], inboxes: Iterable[Inbox[Any]], clock: Clock, until_ns: int, lifeline: Lifeline
) -> None:
    """Handle what comes to the inboxes until `future` is settled, `clock` shows `until_ns`, or the end.

    Raises what the subscriptions' callbacks raise.
    """
    heard = list(inboxes)
    arrivals = _Arrivals()
    for inbox in heard:
        watch(inbox, arrivals.tell)
    future.add_waker(arrivals.tell)
    try:
        while True:
            arrivals.next = Future()  # before looking: what comes from now on completes this one
            for inbox in heard:
                while future.pending() and (event := inbox.take()) is not None:
                    inbox.handle(event)
            if not future.pending() or not block_on_clock(arrivals.next, clock, until_ns, lifeline):
                return
    finally:
        future.remove_waker(arrivals.tell)
        for inbox in heard:
            unwatch(inbox, arrivals.tell)
