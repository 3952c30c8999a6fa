"""The timer that ends queries at their timeouts."""

from __future__ import annotations

from threading import RLock
from time import monotonic

from goalwire.concurrency.poller import Poller, Timer
from goalwire.zenoh.protocol.pending_queries import PendingQueries

NEVER = float('inf')


class QueryTimer:
    """A timer that is set for the earliest timeout among the queries of one session."""

    def __init__(self, poller: Poller) -> None:
        self._poller = poller
        self._lock = RLock()
        self._when = NEVER
        self._timer: Timer | None = None

    def set_for(self, queries: PendingQueries) -> None:
        """Set the timer to the next timeout of `queries`, unless its time is earlier already. Any thread."""
        when = queries.next_timeout
        with self._lock:
            if when >= self._when:
                return
            timer = self._poller.call_later(when - monotonic(), lambda: self._expire(queries))
            later, self._timer, self._when = self._timer, timer, when
        if later is not None:  # cancelled: otherwise each timer that fires would set a further one
            later.cancel()

    def _expire(self, queries: PendingQueries) -> None:
        """End the queries that have timed out, and set the timer for the next timeout."""
        with self._lock:
            timer, self._timer, self._when = self._timer, None, NEVER
        if timer is not None:
            timer.cancel()
        queries.expire()
        if queries.next_timeout != NEVER:
            self.set_for(queries)
