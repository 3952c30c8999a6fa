"""What comes out of a reader, delivered in order by whichever thread is first.

The session's thread delivers what comes from elsewhere. Whoever sends to a reader of its own process delivers
that at once, on its own thread: so, as in ROS 2, a message is there when `publish` returns.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock, get_ident

from goalwire.transport.dds.wire import RawSample, Reader
from goalwire.transport.reports import report_failure

PATIENCE_S = 0.1
"""How long a sender waits for a thread that is just delivering. Only two that wait for each other take it."""


class ReaderDispatcher:
    """One reader and who gets what it takes."""

    __slots__ = ('_deliverer', '_handle', '_title', '_turn', 'closed', 'reader')

    def __init__(self, reader: Reader, title: str, handle: Callable[[RawSample], None]) -> None:
        self.reader = reader
        self.closed = False
        self._title = title
        self._handle = handle
        self._turn = Lock()
        self._deliverer = 0

    def drain(self, patience_s: float = 0.0, *, takes_all: bool = False) -> bool:
        """Deliver what is there, some of it or all; False where another thread is at it.

        The waitset tells of the rest.
        """
        turn = self._turn
        if not turn.acquire(timeout=patience_s):
            return False
        self._deliverer = get_ident()
        reader, handle = self.reader, self._handle
        try:
            while True:
                wanted = reader.at_once
                count, messages = reader.take()
                for message in messages:
                    if self.closed:
                        return True
                    try:
                        handle(message)
                    except Exception as error:
                        report_failure(self._title, error)
                if count < wanted or not takes_all:
                    return True
        finally:
            self._deliverer = 0
            turn.release()

    def drain_own(self) -> None:
        """Deliver what this thread has written, after what another one is just delivering."""
        if not self.drain(takes_all=True) and self._deliverer != get_ident():  # else it takes this one too
            self.drain(PATIENCE_S, takes_all=True)


class LocalReaders:
    """The intakes of this process in one domain, by DDS topic."""

    def __init__(self) -> None:
        self._lock = Lock()
        self.by_topic: dict[str, tuple[ReaderDispatcher, ...]] = {}
        """Looked at with each message: most have no reader here."""

    def add(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Have an intake drained by local writers."""
        with self._lock:
            self.by_topic[topic] = (*self.by_topic.get(topic, ()), dispatcher)

    def remove(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Forget an intake; an unknown one is no error."""
        with self._lock:
            others = tuple(each for each in self.by_topic.get(topic, ()) if each is not dispatcher)
            if others:
                self.by_topic[topic] = others
            else:
                self.by_topic.pop(topic, None)

    def drain(self, topic: str) -> None:
        """Deliver what a writer of this process has just written."""
        for dispatcher in self.by_topic.get(topic, ()):
            dispatcher.drain_own()
