"""Delivers from readers and sends through writers, in order; a slow peer does not hold up the others.

Readers: whichever thread comes first delivers. The session's thread delivers what comes from other
processes. A publisher in the same process delivers its message at once, on its own thread. So, as in ROS 2, a
message has arrived when `publish` returns.

Writers of services: a message waits until there is room for it. The writer keeps all messages: a
history of N could drop a request or reply before it arrived, and the call would stay unanswered. But the
library holds no more than some 500 KB that are not acknowledged (Internal/Watermarks). One peer that is
stopped or cut off takes that room from all others until its lease ends. Neither a server's callback nor its
other clients must wait for that. So if there is no room soon, replies go through a fallback writer. Its short
history drops the replies that the silent peer does not take.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from ctypes import c_uint64
from threading import Lock, Thread, get_ident

from goalwire.concurrency.forks import ForkGuard
from goalwire.concurrency.threads import begin, join_begun
from goalwire.errors import LocalError
from goalwire.fault_reports import report_failure
from goalwire.transport.dds.cyclone.abi import TIMEOUT
from goalwire.transport.dds.cyclone.waitset import CLOSING_S
from goalwire.transport.dds.cyclone.wire import Participant, RawSample, Reader, Writer

PATIENCE_S = 0.1
"""The longest time in s for which a sender waits until another thread has delivered. The wait is limited,
because two senders may wait for each other.
"""


class ReaderDispatcher:
    """One reader, and the function that gets its messages."""

    __slots__ = ('_deliverer', '_handle', '_title', '_turn', 'closed', 'reader')

    def __init__(self, reader: Reader, title: str, handle: Callable[[RawSample], None]) -> None:
        self.reader = reader
        self.closed = False
        self._title = title
        self._handle = handle
        self._turn = Lock()
        self._deliverer = 0

    def drain(self, patience_s: float = 0.0, *, takes_all: bool = False) -> bool:
        """Deliver the messages that have arrived; False if another thread is delivering.

        Without `takes_all` some messages may remain: the waitset calls again for these.
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
        """Deliver the messages that this thread has written, once another thread has finished its
        delivery.
        """
        # If the wait times out, the thread that is delivering takes this message, too.
        if not self.drain(takes_all=True) and self._deliverer != get_ident():
            self.drain(PATIENCE_S, takes_all=True)


class LocalReaders:
    """The readers of this process in one domain, by DDS topic."""

    def __init__(self) -> None:
        self._lock = Lock()
        self.by_topic: dict[str, tuple[ReaderDispatcher, ...]] = {}
        """Each publish looks here before it calls `drain`: most topics have no reader in this process."""

    def add(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Add a reader that local writers drain."""
        with self._lock:
            self.by_topic[topic] = (*self.by_topic.get(topic, ()), dispatcher)

    def discard(self, topic: str, dispatcher: ReaderDispatcher) -> None:
        """Remove a reader; an unknown one is not an error."""
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


_PATIENCE_NS = 200_000_000
"""How long to wait for acknowledgements before sending again, or before using the fallback writer."""
_PARTING_NS = 1_000_000_000
"""How long the fallback writer is kept so that the last messages it sent are acknowledged."""


class QueueingWriter(Writer):
    """A writer that does not wait for room in `write`; its own thread sends messages that found no room."""

    def __init__(
        self,
        participant: Participant,
        topic: str,
        type_name: str,
        qos: int,
        make_fallback: Callable[[], Writer] | None = None,
        guard: ForkGuard | None = None,
    ) -> None:
        """Waiting messages are dropped once `guard` forbids sending; without a guard they are kept."""
        super().__init__(participant, topic, type_name, qos)
        self._make_fallback = make_fallback
        self._guard = guard
        self._fallback_writer: Writer | None = None
        self._waiting: deque[bytes] = deque()
        self._held_up = False
        """True while messages wait, or a fallback writer exists."""
        self._lock = Lock()
        self._thread: Thread | None = None
        self._closed = False

    def write(self, payload: bytes) -> int:
        """Send one message now, or after those that wait; return 0 or the library's error.

        Raises LocalError for bytes that are not a message.
        """
        if not self._held_up:
            result = super().write(payload)
            if result != TIMEOUT:
                return result
        with self._lock:
            if not self._waiting:
                result = (
                    super().write(payload)
                    if self._fallback_writer is None
                    else self._fallback_writer.write(payload)
                )
                if result != TIMEOUT:
                    return result
            if not self._closed:
                self._wait_with(payload)
        return 0

    def _wait_with(self, payload: bytes) -> None:
        self._waiting.append(payload)
        self._held_up = True
        if self._thread is None:
            self._thread = Thread(target=self._send_late, name='goalwire-dds-late', daemon=True)
            begin(self._thread)

    def _send_late(self) -> None:
        """Send the waiting messages in order, until `write` can send directly again."""
        is_free = False
        while not self._is_over(is_free=is_free):
            # A failure other than TIMEOUT means that the writer has gone: then there is nothing to wait for.
            is_free = self.library.dds_wait_for_acks(self.handle, _PATIENCE_NS) != TIMEOUT
            if is_free or self._make_fallback is None or not self._has_others():
                self._send_by(super().write)
            else:
                self._send_by_fallback(self._make_fallback)

    def _has_others(self) -> bool:
        """True if one reader can hold up others. A single reader holds up only itself."""
        return self.library.dds_get_matched_subscriptions(self.handle, (c_uint64 * 1)(), 1) > 1

    def _is_over(self, *, is_free: bool) -> bool:
        """Return whether all has been sent, so that `write` sends the next message directly."""
        while True:
            with self._lock:
                if self._closed:
                    return True
                if self._waiting or (self._fallback_writer is not None and not is_free):
                    return False
                self._held_up = False
                fallback_writer, self._fallback_writer = self._fallback_writer, None
                if fallback_writer is None:
                    self._thread = None
                    return True
            self.library.dds_wait_for_acks(fallback_writer.handle, _PARTING_NS)
            fallback_writer.delete()

    def _send_by_fallback(self, make_fallback: Callable[[], Writer]) -> None:
        if self._fallback_writer is None:
            try:
                made = make_fallback()
            except Exception as error:
                if not self._closed:
                    report_failure(f"topic '{self.topic}'", error)
                return
            with self._lock:
                if self._closed:
                    made.delete()
                    return
                self._fallback_writer = made
        fallback_writer = self._fallback_writer
        if fallback_writer is not None:
            self._send_by(fallback_writer.write)

    def _send_by(self, write: Callable[[bytes], int]) -> None:
        while self._send_first(write):
            pass

    def _send_first(self, write: Callable[[bytes], int]) -> bool:
        """Send the oldest waiting message and remove it; False if none waits, or there is no room."""
        if self._guard is not None and self._guard.is_silent:
            self.discard_waiting()
        failure: LocalError | None = None
        # The lock is held during the write, which does not block. Otherwise `discard_waiting` could run just
        # before the write, and a discarded message would go to the next server.
        with self._lock:
            if not self._waiting:
                return False
            try:
                if write(self._waiting[0]) == TIMEOUT:
                    return False
            except LocalError as error:
                failure = error
            self._waiting.popleft()
        if failure is not None:
            report_failure(f"topic '{self.topic}'", failure)
        return True

    def discard_waiting(self) -> None:
        """Drop the waiting messages, since their receivers have gone."""
        with self._lock:
            self._waiting.clear()

    def delete(self) -> None:
        """Delete the writer, and end its thread."""
        with self._lock:
            self._closed = True
            self._waiting.clear()
            thread = self._thread
            fallback_writer, self._fallback_writer = self._fallback_writer, None
        if thread is None:
            super().delete()
            return
        self.library.dds_delete(self.handle)  # wakes the sending thread, which then ends
        join_begun(thread, CLOSING_S)
        if fallback_writer is not None:
            fallback_writer.delete()
