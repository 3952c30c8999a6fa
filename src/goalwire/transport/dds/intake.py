"""What comes out of a reader, delivered in order by whichever thread is first.

The session's thread delivers what comes from elsewhere. Whoever sends to a reader of its own process delivers
that at once, on its own thread: so, as in ROS 2, a message is there when `publish` returns.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock, get_ident

from goalwire.transport.dds.wire import Reader, Taken
from goalwire.transport.failures import report_failure

PATIENCE_S = 0.1
"""How long a sender waits for a thread that is just delivering. Only two that wait for each other take it."""


class Intake:
    """One reader and who gets what it takes."""

    __slots__ = ('_deliverer', '_handle', '_title', '_turn', 'closed', 'reader')

    def __init__(self, reader: Reader, title: str, handle: Callable[[Taken], None]) -> None:
        self.reader = reader
        self.closed = False
        self._title = title
        self._handle = handle
        self._turn = Lock()
        self._deliverer = 0

    def drain(self) -> None:
        """Deliver some of what is there, unless another thread is at it; the waitset tells of the rest."""
        if self._turn.acquire(blocking=False):
            self._take_turn(takes_all=False)

    def drain_own(self) -> None:
        """Deliver what this thread has written, after what another one is just delivering."""
        if self._turn.acquire(blocking=False):
            self._take_turn(takes_all=True)
            return
        is_ours = self._deliverer == get_ident()  # further up: it takes this one too
        if not is_ours and self._turn.acquire(timeout=PATIENCE_S):
            self._take_turn(takes_all=True)

    def _take_turn(self, *, takes_all: bool) -> None:
        self._deliverer = get_ident()
        reader = self.reader
        try:
            while True:
                wanted = reader.at_once
                count, messages = reader.take()
                for message in messages:
                    if self.closed:
                        return
                    try:
                        self._handle(message)
                    except Exception as error:
                        report_failure(self._title, error)
                if count < wanted or not takes_all:
                    return
        finally:
            self._deliverer = 0
            self._turn.release()


class LocalIntakes:
    """The intakes of this process in one domain, by DDS topic."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._by_topic: dict[str, tuple[Intake, ...]] = {}

    def add(self, topic: str, intake: Intake) -> None:
        """Have an intake drained by local writers."""
        with self._lock:
            self._by_topic[topic] = (*self._by_topic.get(topic, ()), intake)

    def remove(self, topic: str, intake: Intake) -> None:
        """Forget an intake; an unknown one is no error."""
        with self._lock:
            others = tuple(each for each in self._by_topic.get(topic, ()) if each is not intake)
            if others:
                self._by_topic[topic] = others
            else:
                self._by_topic.pop(topic, None)

    def drain(self, topic: str) -> None:
        """Deliver what a writer of this process has just written."""
        for intake in self._by_topic.get(topic, ()):
            intake.drain_own()
