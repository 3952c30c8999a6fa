"""A declared thing's place on the wire: whether it is still held, and how it is given up."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock

from goalwire.errors import ClosedError
from goalwire.transport.fork import ForkGuard
from goalwire.transport.reject_counters import LOGGER

OTHER_CLOSER_S = 15.0
"""How long to wait for another thread that closes the same; a mute peer can hold it up for 10 s."""


class EndpointState:
    """One place."""

    __slots__ = ('_leave', '_turn', 'closed', 'guard', 'logger', 'title')

    def __init__(self, title: str, guard: ForkGuard, leave: Callable[[], None], logger: str = LOGGER) -> None:
        self.title = title
        self.logger = logger
        """The name of the logger that tells what goes wrong here."""
        self.closed = False
        self.guard = guard
        """Shared by all of a session. Looked at with each message, past `is_forked`: a call less."""
        self._leave = leave
        self._turn = RLock()

    @property
    def is_forked(self) -> bool:
        """True in a child forked since."""
        return self.guard.is_forked

    def check(self) -> None:
        """Raise ClosedError or ForkedError where the place is no longer held."""
        if self.guard.is_forked:
            self.guard.check(self.title)
        if self.closed:
            raise ClosedError(
                f'{self.title} was used after it, its node or its context had been closed; '
                f'declare it again, or stop using it first'
            )

    def check_sending(self) -> None:
        """Raise ClosedError or ForkedError where a publisher or a client must not send."""
        self.check()
        if self.guard.is_silent:
            raise ClosedError(f'{self.title} was used after the end of its context; stop using it first')

    def close(self) -> None:
        """Undeclare, once; a forked child has nothing to undeclare.

        Whoever comes second waits for the first, so that it may rely on the end as well; a call from within
        the closing itself returns at once.
        """
        if self.guard.is_forked or not self._turn.acquire(timeout=OTHER_CLOSER_S):
            return
        try:
            if not self.closed:
                self.closed = True
                self._leave()
        finally:
            self._turn.release()
