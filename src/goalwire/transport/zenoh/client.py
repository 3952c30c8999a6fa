"""Service clients: requests on their way, and what comes back (zenoh-wire A.4)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from time import time_ns

import zenoh
from zenoh.handlers import Callback

from goalwire.errors import RemoteError, TransportError, peer_text
from goalwire.transport.contract import ClientPort, Sample
from goalwire.transport.place import Place
from goalwire.transport.zenoh.attachment import GID_SIZE, encode
from goalwire.transport.zenoh.config import reason
from goalwire.transport.zenoh.core import Core
from goalwire.transport.zenoh.queriers import Queriers
from goalwire.transport.zenoh.samples import sample_of
from goalwire.transport.zenoh.thread_state import pin


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
        answer = reply.ok
        if answer is None:
            self._reason = self._reason or _error_of(reply)
            return
        client, sequence = self._client, self._sequence
        try:
            sample = sample_of(answer)
        except RemoteError as error:
            client.reject(error)
            return
        if sample.sequence != sequence:
            client.reject(f'it answers request {sample.sequence}, not {sequence}')
        elif sequence in client.waiting:
            self._on_reply(sample)

    def dropped(self) -> None:
        """Zenoh has let go of the call, no reply can come any more: end it unless closing did."""
        pin()
        client = self._client
        try:
            if client.waiting.pop(self._sequence, None) is not None:  # one thread gets it
                self._on_end(self._reason)
        finally:
            client.core.in_flight.leave(self)

    def end(self) -> None:
        """End it: the client closes."""
        if self._client.waiting.pop(self._sequence, None) is not None:
            self._on_end(self._reason)


def _error_of(reply: zenoh.Reply) -> str:
    """Return the text of an error report: a server's, or zenoh's own 'Timeout'."""
    error = reply.err
    return '' if error is None else peer_text(error.payload.to_bytes().decode(errors='replace'))


class ZenohClient(ClientPort):
    """A declared service client."""

    def __init__(self, place: Place, core: Core, gid: bytes, queriers: Queriers) -> None:
        self.gid = gid
        self.core = core
        self.waiting: dict[int, Call] = {}
        """The requests that have not ended, by their sequence numbers."""
        self._place = place
        self._queriers = queriers
        self._next_sequence = count(1).__next__

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request to every server."""
        place = self._place
        if place.closed or place.guard.is_silent:
            place.check_sending()
        sequence = self._next_sequence()
        call = Call(self, sequence, on_reply, on_end)
        self.waiting[sequence] = call
        self.core.in_flight.enter(call)
        try:
            queriers = self._queriers
            get = queriers.get if timeout_ns is None else queriers.get_within(timeout_ns)
            get(
                handler=Callback(call.replied, drop=call.dropped, indirect=False),
                payload=payload,
                attachment=encode(sequence, time_ns(), GID_SIZE, self.gid),
                cancellation_token=call.token,
            )
        except (zenoh.ZError, RuntimeError) as error:
            self.waiting.pop(sequence, None)
            self.core.in_flight.leave(call)
            place.check()  # closed by another thread in the meantime
            raise TransportError(f'{place.title}: zenoh refused a request: {reason(error)}') from None
        return sequence

    def forget(self, sequence: int) -> None:
        """Hold nothing for this request any more; a reply that is being handed over is waited for."""
        call = self.waiting.pop(sequence, None)
        if call is not None and not self._place.guard.is_forked:
            call.token.cancel()  # type: ignore[no-untyped-call]

    def release(self) -> None:
        """Take the queriers off the wire and end every call."""
        self._queriers.undeclare()
        for call in list(self.waiting.values()):
            call.end()

    def reject(self, error: RemoteError | str) -> None:
        """Count a reply that cannot be used."""
        self.core.rejects.add('reply', error, self._place)

    def close(self) -> None:
        """Undeclare and end every call."""
        self._place.give_up()
