"""Service clients, with faults: their calls end where a partition has hidden every server."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.transport.contract import ClientPort, Sample
from goalwire.transport.failures import report_failure
from goalwire.transport.faults.plan import Faults

if TYPE_CHECKING:
    from goalwire.rules.qos_events import EventStatus, EventType


class FaultyCall:
    """One request that waits. It ends once, by the wire or because its servers are out of sight."""

    def __init__(
        self, client: FaultyClient, on_reply: Callable[[Sample], None], on_end: Callable[[str], None]
    ) -> None:
        self._client = client
        self._on_reply = on_reply
        self._on_end = on_end
        self.sequence = 0
        self.is_over = False

    def on_reply(self, sample: Sample) -> None:
        """Hand a reply over, unless the call has ended."""
        if not self.is_over:
            self._on_reply(sample)

    def on_end(self, reason: str) -> None:
        """End, the first time."""
        if self._client.ended(self):
            self._on_end(reason)


class FaultyClient(ClientPort):
    """A service client, with faults. `is_blind` says whether its servers are there and cannot be seen."""

    def __init__(self, inner: ClientPort, faults: Faults, is_blind: Callable[[], bool]) -> None:
        self._inner = inner
        self.gid = inner.gid
        self._faults = faults
        self._is_blind = is_blind
        self._lock = Lock()
        self._calls: dict[int, FaultyCall] = {}

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request."""
        self._faults.call('client.request')
        call = FaultyCall(self, on_reply, on_end)
        sequence = self._inner.request(payload, call.on_reply, call.on_end, timeout_ns)
        with self._lock:
            if not call.is_over:
                call.sequence = sequence
                self._calls[sequence] = call
        if self._is_blind():
            call.sequence = sequence
            self._end(call)
        return sequence

    def ended(self, call: FaultyCall) -> bool:
        """A call has ended; False where it had before."""
        with self._lock:
            was_over, call.is_over = call.is_over, True
            self._calls.pop(call.sequence, None)
        return not was_over

    def cancel(self, sequence: int) -> None:
        """Hold nothing for this request any more."""
        self._faults.call('client.cancel')
        with self._lock:
            call = self._calls.pop(sequence, None)
            if call is not None:
                call.is_over = True
        self._inner.cancel(sequence)

    def look_again(self) -> None:
        """End the calls of a client that sees its servers no longer."""
        if not self._is_blind():
            return
        with self._lock:
            calls = list(self._calls.values())
        for call in calls:
            self._end(call)

    def _end(self, call: FaultyCall) -> None:
        """End a call of which the wire has not said that it has ended."""
        try:
            call.on_end('')
        except Exception as error:
            report_failure('client under faults', error)
        self._inner.cancel(call.sequence)

    def reaches_server(self) -> bool:
        """Whether a server that the graph shows can be called already."""
        self._faults.call('client.reaches_server')
        return self._inner.reaches_server()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Watch what the wire finds out itself."""
        self._faults.call('port.watch_event')
        return self._inner.watch_event(event, changed)

    def close(self) -> None:
        """Undeclare and end every call."""
        self._inner.close()
        self._faults.call('port.close')
