"""A writer that loses nothing and holds nobody up: what it has no room for is sent when there is room.

A service's writer keeps all: what a history of N drops before the other side has it is a call that nobody
answers. But the library takes in no more than some 500 KB that are not acknowledged (Internal/Watermarks):
one peer that is stopped or cut off takes the room from all, until its lease ends. A server's callback, or its
asyncio loop, must not wait for that.
"""

from __future__ import annotations

from collections import deque
from threading import Lock, Thread

from goalwire.errors import LocalError
from goalwire.transport.dds.abi import TIMEOUT
from goalwire.transport.dds.pump import CLOSING_S
from goalwire.transport.dds.wire import Participant, Writer
from goalwire.transport.failures import report_failure

_PATIENCE_NS = 1_000_000_000
"""How long until the next attempt, unless all is acknowledged, or the writer gone, before."""


class PatientWriter(Writer):
    """A writer whose QoS says not to wait for room; a thread of its own waits instead, while it has to."""

    def __init__(self, participant: Participant, topic: str, type_name: str, qos: int) -> None:
        super().__init__(participant, topic, type_name, qos)
        self._waiting: deque[bytes] = deque()
        self._lock = Lock()
        self._thread: Thread | None = None
        self._closed = False

    def write(self, payload: bytes) -> int:
        """Send one message now, or after those that wait; return 0 or the library's error.

        Raises LocalError for bytes that are no message.
        """
        if not self._waiting:
            result = super().write(payload)
            if result != TIMEOUT:
                return result
        with self._lock:
            if not self._closed:
                self._waiting.append(payload)
                if self._thread is None:
                    self._thread = Thread(target=self._send_late, name='goalwire-dds-late', daemon=True)
                    self._thread.start()
        return 0

    def _send_late(self) -> None:
        """Send what waits, in order, whenever all that went before has been acknowledged."""
        while True:
            self.library.dds_wait_for_acks(self.handle, _PATIENCE_NS)
            while self._send_first():
                pass
            with self._lock:
                if not self._waiting:
                    self._thread = None
                    return

    def _send_first(self) -> bool:
        """Send what has waited longest and let it wait no more; False where there is nothing, or no room."""
        with self._lock:
            if not self._waiting:
                return False
            first = self._waiting[0]
        try:
            if super().write(first) == TIMEOUT:
                return False
        except LocalError as error:
            report_failure(f"topic '{self.topic}'", error)
        with self._lock:
            if self._waiting and self._waiting[0] is first:  # not forgotten in the meantime
                self._waiting.popleft()
        return True

    def forget_waiting(self) -> None:
        """Send nothing of what waits: whom it was for has gone."""
        with self._lock:
            self._waiting.clear()

    def delete(self) -> None:
        """Take it off the wire, and end the thread."""
        with self._lock:
            self._closed = True
            self._waiting.clear()
            thread = self._thread
        if thread is None:
            super().delete()
            return
        self.library.dds_delete(self.handle)  # ends the thread's waiting
        thread.join(CLOSING_S)
