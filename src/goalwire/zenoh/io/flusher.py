"""Sends what links hold back in a flood within milliseconds, whatever their publishers do next.

Mostly it goes out before: with the messages that follow, or when the publishing thread goes to sleep in an
executor. A thread of the session's sees to the rest, as Zenoh's own does; it is started with the first flood.
Only what holds the interpreter's lock all the time delays it longer.
"""

from __future__ import annotations

from _thread import allocate_lock
from contextlib import suppress
from threading import Thread

from goalwire.concurrency.threads import join_begun
from goalwire.zenoh.protocol.outgoing import Outgoing

HOLD_S = 0.001
"""As long as Zenoh holds back what it collects, by default."""
LONGEST_HOLD_S = 0.005
"""The same while a flood goes on, which sends all that it holds back itself: to look costs 20 µs each time.
Whoever wants the interpreter's lock waits as long."""


class Flusher:
    """One session's. `held` are the links that hold something back."""

    def __init__(self, name: str) -> None:
        """`name` is that of the thread."""
        self.held: list[Outgoing] = []
        self._name = name
        self._thread: Thread | None = None
        self._holds = 0
        self._sleeps = False
        self._is_closed = False
        self._gate = allocate_lock()
        self._gate.acquire()

    def hold(self, link: Outgoing) -> None:
        """Have `link` soon send what it holds back. The link's lock is held."""
        self._holds += 1
        self.held.append(link)  # then look who sleeps; who goes to sleep looks here after having said so
        if self._sleeps:
            self._wake()
        elif self._thread is None:
            self._start()

    def _start(self) -> None:
        self._thread = Thread(target=self._run, name=self._name, daemon=True)
        try:
            self._thread.start()
        except RuntimeError:  # the interpreter ends, or there are too many threads
            self._thread = None
            self.flush()

    def _wake(self) -> None:
        with suppress(RuntimeError):  # the thread is awake already
            self._gate.release()

    def flush(self) -> None:
        """Send everything that is held back now."""
        while self.held:
            try:
                link = self.held.pop()
            except IndexError:
                return  # another thread sends it
            link.release()

    def _run(self) -> None:
        while not self._is_closed:
            self._sleeps = True
            if not self.held:
                self._gate.acquire()
            self._sleeps = False
            self._follow_flood()

    def _follow_flood(self) -> None:
        """Look again and again, until a look finds nothing held back."""
        period, holds = HOLD_S, -1
        while holds != self._holds and not self._is_closed:
            holds = self._holds
            self._gate.acquire(timeout=period)
            self.flush()
            period = min(2 * period, LONGEST_HOLD_S)

    def close(self) -> None:
        """Send what is held back, then end the thread."""
        self.flush()
        self._is_closed = True
        self._wake()
        if self._thread is not None:
            join_begun(self._thread)
