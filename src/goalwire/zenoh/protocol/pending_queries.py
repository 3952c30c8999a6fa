"""The queries that a session has sent, by number, until their last answer or their timeout.

No lock is held: a query is put into the table, or taken out, in one step. So if two threads end a query, only
one of them finds it.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from goalwire.zenoh.protocol.queries import TIMEOUT, Answer, PendingQuery


class PendingQueries:
    """One session's queries that wait for answers."""

    def __init__(
        self,
        clock: Callable[[], float],
        expire_sooner: Callable[[], None],
        report: Callable[[Exception], None],
    ) -> None:
        """`expire_sooner` is called if `next_timeout` becomes earlier; `report` gets errors of callbacks."""
        self.pending: dict[int, PendingQuery] = {}
        self.next_timeout = float('inf')
        """The earliest timeout of a query, on `clock`: `expire` has to be called then."""
        self._clock = clock
        self._expire_sooner = expire_sooner
        self._report = report
        self._next_request = count(1).__next__

    def add(self, query: PendingQuery) -> int:
        """Register a query before it is sent; return its number."""
        request = self._next_request() & 0xFFFF_FFFF
        # Numbers wrap around after 2^32 queries, and an old number may still be in use.
        while request in self.pending:
            request = self._next_request() & 0xFFFF_FFFF
        self.pending[request] = query
        if query.deadline < self.next_timeout:
            self.next_timeout = query.deadline
            self._expire_sooner()
        return request

    def cancel(self, request: int) -> None:
        """Cancel a query: its callbacks are not called from now on.

        A query that has ended is ignored.
        """
        query = self.pending.pop(request, None)
        if query is not None:
            query.left.clear()

    def find(self, who: object, request: int) -> PendingQuery | None:
        """Return a query that still waits for an answer from `who`; None if there is none."""
        query = self.pending.get(request)
        return query if query is not None and who in query.left else None

    def take_reply(self, who: object, request: int, answer: Answer) -> None:
        """Hand an answer to the query that waits for it, if there is one."""
        query = self.pending.get(request)
        if query is not None and who in query.left:
            self._reply(query, answer)

    def take_final(self, who: object, request: int) -> None:
        """Take note that `who`, which was asked, has given its last answer."""
        query = self.pending.get(request)
        if query is None:
            return
        try:
            query.left.remove(who)
        except ValueError:
            return
        # If several threads come here, only the thread that removes the query from the table ends it.
        if not query.left and self.pending.pop(request, None) is not None:
            self.end(query)

    def remove_asked(self, who: object) -> list[PendingQuery]:
        """Stop waiting for `who`, which has gone; return the queries that now wait for nobody."""
        ended = []
        for request, query in list(self.pending.items()):
            if who in query.left:
                query.left.remove(who)
                if not query.left and self.pending.pop(request, None) is not None:
                    ended.append(query)
        return ended

    def expire(self) -> None:
        """End the queries that have timed out."""
        now = self._clock()
        over = [request for request, query in list(self.pending.items()) if query.deadline <= now]
        ended = [query for query in (self.pending.pop(each, None) for each in over) if query is not None]
        # Reset first, then search: a query that another thread adds meanwhile then lowers `next_timeout`.
        self.next_timeout = float('inf')
        earliest = min((query.deadline for query in list(self.pending.values())), default=float('inf'))
        self.next_timeout = min(self.next_timeout, earliest)
        for query in ended:
            for _ in query.left:
                self._reply(query, TIMEOUT)
            query.left.clear()
            self.end(query)

    def end(self, query: PendingQuery) -> None:
        """Tell the asking side that a query has ended."""
        try:
            query.end()
        except Exception as error:
            self._report(error)

    def _reply(self, query: PendingQuery, answer: Answer) -> None:
        try:
            query.reply(answer)
        except Exception as error:
            self._report(error)
