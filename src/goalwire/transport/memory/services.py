"""Service servers and clients of the memory transport.

A call is handed to every server there is at that moment. It ends when each of them has answered, given its
request up, or gone; or when the client goes.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from time import time_ns

from goalwire.errors import LocalError
from goalwire.transport.contract import ClientPort, Port, Request, Sample
from goalwire.transport.failures import report_failure
from goalwire.transport.memory.endpoint_state import MemoryEndpointState


def _to_nobody(_: object) -> None:
    """Stand in for the functions of a caller that has given up."""


class MemoryCall:
    """One request on its way at the client's side."""

    __slots__ = ('_client', '_lock', '_on_end', '_on_reply', '_open', '_reason', '_sequence', 'requests')

    def __init__(
        self,
        client: MemoryClient,
        sequence: int,
        servers: int,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
    ) -> None:
        self._client = client
        self._sequence = sequence
        self._on_reply = on_reply
        self._on_end = on_end
        self._open = servers
        self._reason = ''
        self._lock = Lock()
        self.requests: list[MemoryRequest] = []
        """What the servers have of it."""

    def answered(self, sample: Sample) -> None:
        """Hand one server's reply over; then that server is done."""
        if self._open > 0:
            self._client.run(self._on_reply, sample)
        self.server_done()

    def server_done(self, reason: str = '') -> None:
        """Count one server out; `on_end` fires after the last, so after every reply."""
        with self._lock:
            self._reason = self._reason or reason
            self._open -= 1
            is_last = self._open == 0
        if is_last:
            self._end()

    def cancel(self) -> None:
        """Tell nobody of what servers answer yet, and let them hold nothing for it."""
        with self._lock:
            self._open = 0
        self._on_reply, self._on_end = _to_nobody, _to_nobody
        while self.requests:
            self.requests.pop().discard()

    def close(self) -> None:
        """End the call although servers have not answered: the client is closing."""
        with self._lock:
            was_open, self._open = self._open > 0, 0
        if was_open:
            self._end()

    def _end(self) -> None:
        on_end = self._on_end
        self._client.cancel(self._sequence)
        self._client.run(on_end, self._reason)


class MemoryRequest(Request):
    """A call as one server sees it."""

    __slots__ = ('_call', '_is_answered', '_server', 'sample')

    def __init__(self, server: MemoryService, call: MemoryCall, sample: Sample) -> None:
        self.sample = sample
        self._server = server
        self._call = call
        self._is_answered = False

    def reply(self, payload: bytes) -> None:
        """Answer on this thread. Raises LocalError the second time; a caller that has gone hears nothing."""
        if self._is_answered:
            raise LocalError(f'{self._server.state.title}: this request was answered before; answer it once')
        self._is_answered = True
        if self._server.discard(self):
            now = time_ns()
            self._call.answered(Sample(bytes(payload), self.sample.sequence, now, now, self.sample.gid))

    def discard(self) -> None:
        """Nobody waits for the answer any more."""
        self._server.discard(self)

    def cancel(self, reason: str = '') -> None:
        """Give the request up; harmless after an answer."""
        if self._server.discard(self):
            self._call.server_done(reason)


class MemoryService(Port):
    """A declared service server."""

    def __init__(self, state: MemoryEndpointState, deliver: Callable[[Request], None]) -> None:
        self.state = state
        self.gid = state.entity.gid
        self._deliver = deliver
        self._lock = Lock()
        self._waiting: set[MemoryRequest] = set()

    def accept(self, call: MemoryCall, sample: Sample) -> None:
        """Take one call in; where the server has just gone, or fails, the call ends at once."""
        request = MemoryRequest(self, call, sample)
        call.requests.append(request)
        with self._lock:
            self._waiting.add(request)
        if self.state.closed:
            request.cancel()
            return
        try:
            self._deliver(request)
        except Exception as error:
            report_failure(self.state.title, error)
            request.cancel()

    def discard(self, request: MemoryRequest) -> bool:
        """Take a request off the list; True for the one caller that found it there."""
        with self._lock:
            if request in self._waiting:
                self._waiting.remove(request)
                return True
            return False

    def close(self) -> None:
        """Undeclare and give every unanswered request up."""
        self.state.close()

    def cancel_all(self) -> None:
        """Give every unanswered request up."""
        with self._lock:
            waiting = list(self._waiting)
        for request in waiting:
            request.cancel()


class MemoryClient(ClientPort):
    """A declared service client."""

    def __init__(self, state: MemoryEndpointState, servers: Callable[[], tuple[MemoryService, ...]]) -> None:
        self.state = state
        self.gid = state.entity.gid
        self._servers = servers
        self._lock = Lock()
        self._sequence = 0
        self._calls: dict[int, MemoryCall] = {}

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,  # noqa: ARG002 - it is cancelled in time
    ) -> int:
        """Hand one request to every server, on this thread."""
        self.state.check_sending()
        payload = bytes(payload)
        servers = self._servers()
        with self._lock:
            self._sequence += 1
            sequence = self._sequence
            call = MemoryCall(self, sequence, len(servers), on_reply, on_end)
            if servers:
                self._calls[sequence] = call
        if not servers:
            self.run(on_end, '')
            return sequence
        if self.state.closed:  # closed since the check above: close() may have missed this call
            call.close()
        now = time_ns()
        for server in servers:
            server.accept(call, Sample(payload, sequence, now, now, self.gid))
        return sequence

    def run(self, callback: Callable[..., None], *arguments: Sample | str) -> None:
        """Run a caller's function; its failure is logged, not raised into the server's thread."""
        try:
            callback(*arguments)
        except Exception as error:
            report_failure(self.state.title, error)

    def cancel(self, sequence: int) -> None:
        """Hold nothing for a call that has ended, or that nobody waits for any more."""
        call = self._calls.pop(sequence, None)
        if call is not None:
            call.cancel()

    def close(self) -> None:
        """Undeclare and end every call."""
        self.state.close()

    def close_calls(self) -> None:
        """End every call."""
        with self._lock:
            calls = list(self._calls.values())
        for call in calls:
            call.close()
