"""Service clients: requests on their way, and what comes back (zenoh-wire A.4)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from time import time_ns

import zenoh

from goalwire.errors import RemoteError, TransportError
from goalwire.transport.contract import ClientPort, Sample, new_sample
from goalwire.transport.place import Place
from goalwire.transport.zenoh.attachment import encode, read
from goalwire.transport.zenoh.config import reason
from goalwire.transport.zenoh.core import Core
from goalwire.transport.zenoh.queriers import Queriers
from goalwire.transport.zenoh.thread_state import pin

_REASON_LIMIT = 500
"""Characters of a server's reason that are shown."""


class Call:
    """One request on its way."""

    __slots__ = ('_client', '_on_end', '_on_reply', '_reason', '_sequence', 'token')

    def __init__(
        self,
        client: ZenohClient,
        sequence: int,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
    ) -> None:
        self._client = client
        self._sequence = sequence
        self._on_reply = on_reply
        self._on_end = on_end
        self._reason = ''
        self.token = zenoh.CancellationToken()
        """What ends the query at once; without that zenoh holds it until its time is over."""

    def replied(self, reply: zenoh.Reply) -> None:
        """Hand a reply over; runs on zenoh's thread, or the caller's within one session."""
        pin()
        received = time_ns()
        answer = reply.ok
        if answer is None:
            self._reason = self._reason or _error_of(reply)
            return
        try:
            sample = _read(answer, self._sequence, received)
        except RemoteError as error:
            self._client.reject(error)
            return
        if self._client.is_waiting(self._sequence):
            self._on_reply(sample)

    def dropped(self) -> None:
        """Zenoh has let go of the call: no reply can come any more."""
        pin()
        self._client.dropped(self, self._sequence)

    def ended(self) -> None:
        """Tell the caller, and why no server has answered, where one said so."""
        self._on_end(self._reason)


def _error_of(reply: zenoh.Reply) -> str:
    """Return the text of an error report: a server's, or zenoh's own 'Timeout'."""
    error = reply.err
    return '' if error is None else error.payload.to_bytes().decode(errors='replace')[:_REASON_LIMIT]


def _read(answer: zenoh.Sample, expected: int, received: int) -> Sample:
    """Return what a server sent; raises RemoteError for another request's answer."""
    sequence, sent, gid = read(answer.attachment)
    if sequence != expected:
        raise RemoteError(f'it answers request {sequence}, not {expected}')
    return new_sample((answer.payload.to_bytes(), sequence, sent, received, gid))


class ZenohClient(ClientPort):
    """A declared service client."""

    def __init__(self, place: Place, core: Core, gid: bytes, queriers: Queriers) -> None:
        self.gid = gid
        self._place = place
        self._core = core
        self._queriers = queriers
        self._next_sequence = count(1).__next__
        self._waiting: dict[int, Call] = {}

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request to every server."""
        self._place.check()
        sequence = self._next_sequence()
        call = Call(self, sequence, on_reply, on_end)
        self._waiting[sequence] = call
        self._core.in_flight.enter(call)
        try:
            queriers = self._queriers
            get = queriers.get if timeout_ns is None else queriers.get_within(timeout_ns)
            get(
                handler=zenoh.handlers.Callback(call.replied, drop=call.dropped, indirect=False),
                payload=payload,
                attachment=encode(sequence, time_ns(), self.gid),
                cancellation_token=call.token,
            )
        except (zenoh.ZError, RuntimeError) as error:
            self._waiting.pop(sequence, None)
            self._core.in_flight.leave(call)
            self._place.check()  # closed by another thread in the meantime
            raise TransportError(f'{self._place.title}: zenoh refused a request: {reason(error)}') from None
        return sequence

    def forget(self, sequence: int) -> None:
        """Hold nothing for this request any more; a reply that is being handed over is waited for."""
        call = self._waiting.pop(sequence, None)
        if call is not None and not self._place.is_forked:
            call.token.cancel()  # type: ignore[no-untyped-call]

    def is_waiting(self, sequence: int) -> bool:
        """True until the request has ended."""
        return sequence in self._waiting

    def dropped(self, call: Call, sequence: int) -> None:
        """End a call unless closing did."""
        try:
            self._end(sequence)
        finally:
            self._core.in_flight.leave(call)

    def _end(self, sequence: int) -> None:
        call = self._waiting.pop(sequence, None)  # one thread gets it
        if call is not None:
            call.ended()

    def release(self) -> None:
        """Take the queriers off the wire and end every call."""
        self._queriers.undeclare()
        for sequence in list(self._waiting):
            self._end(sequence)

    def reject(self, error: RemoteError) -> None:
        """Count a reply that cannot be used."""
        self._core.rejects.add('reply', f'{self._place.title}: {error}')

    def close(self) -> None:
        """Undeclare and end every call."""
        self._place.give_up()
