"""Sends held-back messages within milliseconds, even if their publisher does nothing more.

In a flood, links hold small messages back to send them together. Most go out with the messages that follow,
or when the publishing thread goes to sleep in an executor. A thread of the session's sends the rest, as
Zenoh's own does; it is started with the first flood. Only code that keeps the GIL can delay the rest longer.
"""

from __future__ import annotations

from _thread import allocate_lock
from contextlib import suppress
from threading import Thread

from goalwire.concurrency.threads import begin, join_begun
from goalwire.zenoh.protocol.outgoing import Outgoing

HOLD_S = 0.001
"""How long messages are held back at most; Zenoh's own default."""
LONGEST_HOLD_S = 0.005
"""How long messages are held back at most during a flood, whose next messages push them out anyway. A shorter
time means more checks: each costs 20 µs, in which other threads wait for the GIL."""


class Flusher:
    """The flusher of one session. `held` are the links that hold messages back."""

    def __init__(self, name: str) -> None:
        """`name` is the name of the thread."""
        self.held: list[Outgoing] = []
        self._name = name
        self._thread: Thread | None = None
        self._holds = 0
        self._sleeps = False
        self._is_closed = False
        self._gate = allocate_lock()
        self._gate.acquire()

    def hold(self, link: Outgoing) -> None:
        """Have `link` send its held-back messages soon. The caller holds the link's lock."""
        self._holds += 1
        self.held.append(link)
        # `_sleeps` is read after `held` has changed: the thread sets `_sleeps` before it reads `held`.
        if self._sleeps:
            self._wake()
        elif self._thread is None:
            self._start()

    def _start(self) -> None:
        self._thread = Thread(target=self._run, name=self._name, daemon=True)
        try:
            begin(self._thread)
        except RuntimeError:  # no thread can start: the interpreter ends, or too many run
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
                return  # another thread sends this link's messages
            link.release()

    def _run(self) -> None:
        """Sleep until a link holds messages back, then follow the flood; the session's thread runs this."""
        while not self._is_closed:
            self._sleeps = True
            if not self.held:
                self._gate.acquire()
            self._sleeps = False
            self._follow_flood()

    def _follow_flood(self) -> None:
        """Send held-back messages repeatedly, until a check finds none."""
        period, holds = HOLD_S, -1
        while holds != self._holds and not self._is_closed:
            holds = self._holds
            self._gate.acquire(timeout=period)
            self.flush()
            period = min(2 * period, LONGEST_HOLD_S)

    def close(self) -> None:
        """Send the held-back messages, then end the thread."""
        self.flush()
        self._is_closed = True
        self._wake()
        if self._thread is not None:
            join_begun(self._thread)
