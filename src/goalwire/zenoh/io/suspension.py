"""Makes a session whole again after its process was suspended: others have closed their links meanwhile.

A process that is suspended (SIGSTOP, a debugger, a laptop that sleeps) sends nothing, so its peers close its
links after its lease. When it goes on, its own links look alive until it reads their ends, and messages sent
over them are lost. So a query waits until every link has been read, and until the ended links are back.
"""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from goalwire.concurrency.blocked_calls import BlockedCalls
from goalwire.concurrency.poller import Poller, Timer
from goalwire.zenoh.protocol.session_protocol import SessionProtocol

READING_TURNS = 64
"""How often a link is read before it counts as alive. Each read takes up to 64 KiB."""
RELINK_S = 3.0
"""How long links may take to come back after this process was stopped and the others closed them."""


class Relinking:
    """Notices that one session's process was stopped, and waits for its links to come back."""

    def __init__(
        self,
        protocol: SessionProtocol,
        poller: Poller,
        blocked_calls: BlockedCalls,
        has_settled: Callable[[], bool],
        lease_s: float,
    ) -> None:
        """`has_settled` returns True if all nodes to connect to are linked; `lease_s` is this side's own
        lease.
        """
        self._protocol = protocol
        self._poller = poller
        self._blocked_calls = blocked_calls
        self._has_settled = has_settled
        self._lease_s = lease_s
        self._lost: set[bytes] = set()
        """The sessions whose links have ended since the stop."""
        self._timer: Timer | None = None
        """The timer that runs from the end of a stop until the remaining links count as alive."""

    def note_running(self, now: float) -> None:
        """Take note that this process runs. If it was stopped for a lease, its peers have closed their links.

        Then queries wait until these links are there again (`wait`), for RELINK_S from now at most.
        """
        protocol = self._protocol
        if now <= protocol.stale_after or protocol.stale_after == float('inf'):
            protocol.stale_after = now + self._lease_s
        elif self._timer is None:
            self._timer = self._poller.call_later(RELINK_S, self._believe_links)

    def note_lost(self, zid: bytes) -> None:
        """Take note that the link to a session has ended."""
        self.note_running(monotonic())
        if self._timer is not None and zid:
            self._lost.add(zid)

    def _believe_links(self) -> None:
        """End the doubt after a stop: the remaining links count as alive for another lease."""
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()
        self._lost.clear()
        self._protocol.stale_after = monotonic() + self._lease_s
        self._blocked_calls.wake_all()

    def wait(self) -> None:
        """Wait until the links that ended while this process was stopped are back."""
        turns = 0

        def count_turn() -> None:
            nonlocal turns
            turns += 1
            if turns < READING_TURNS:
                self._poller.call(count_turn)
            else:
                self._blocked_calls.wake_all()

        self.note_running(monotonic())
        # Each turn of the poller reads every link once, so the ends of all links are seen within these turns.
        self._poller.call(count_turn)
        self._blocked_calls.wait_until(lambda: turns >= READING_TURNS, RELINK_S)
        self._blocked_calls.wait_until(self._is_relinked, RELINK_S)
        self._believe_links()

    def _is_relinked(self) -> bool:
        return self._timer is None or (
            all(map(self._protocol.is_linked, list(self._lost))) and self._has_settled()
        )
