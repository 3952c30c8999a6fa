"""Service clients: requests on their way, and what comes back (zenoh-wire A.4)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from time import time_ns

from goalwire.errors import RemoteError, TransportError, peer_text
from goalwire.transport.contract import ClientPort, Sample
from goalwire.transport.endpoint import EndpointState, OpenPort
from goalwire.transport.zenoh.attachment import GID_SIZE, encode
from goalwire.transport.zenoh.context import ZenohContext
from goalwire.transport.zenoh.protocol.network import ReplyError
from goalwire.transport.zenoh.samples import sample_of
from goalwire.transport.zenoh.wire import Message, Querier


class ZenohCall:
    """One request on its way."""

    __slots__ = ('_client', '_on_end', '_on_reply', '_reason', '_sequence', 'asked')

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
        self.asked: object = None
        """What the wire knows it by; None until it was sent."""

    def answered(self, answer: Message | ReplyError) -> None:
        """Hand a reply over; runs on the wire's thread, or the caller's within one session."""
        if type(answer) is ReplyError:
            self._reason = self._reason or peer_text(answer.payload.decode(errors='replace'))
            return
        client, sequence = self._client, self._sequence
        try:
            sample = sample_of(answer)  # type: ignore[arg-type]
        except RemoteError as error:
            client.reject(error)
            return
        if sample.sequence != sequence:
            client.reject(f'it answers request {sample.sequence}, not {sequence}')
        elif sequence in client.waiting:
            self._on_reply(sample)

    def end(self) -> None:
        """No reply can come any more, or the client closes: end it once."""
        if self._client.waiting.pop(self._sequence, None) is not None:  # one thread gets it
            self._on_end(self._reason)


class ZenohClient(OpenPort, ClientPort):
    """A declared service client."""

    def __init__(self, state: EndpointState, context: ZenohContext, gid: bytes, querier: Querier) -> None:
        super().__init__(state, gid)
        self.context = context
        self.waiting: dict[int, ZenohCall] = {}
        """The requests that have not ended, by their sequence numbers."""
        self._querier = querier
        self._next_sequence = count(1).__next__

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request to every server."""
        state = self.state
        if state.closed or state.guard.is_silent:
            state.check_sending()
        sequence = self._next_sequence()
        call = ZenohCall(self, sequence, on_reply, on_end)
        self.waiting[sequence] = call
        attachment = encode(sequence, time_ns(), GID_SIZE, self.gid)
        try:
            call.asked = self._querier.ask(payload, attachment, call.answered, call.end, timeout_ns)
        except self.context.errors as error:
            self.waiting.pop(sequence, None)
            state.check()  # closed by another thread in the meantime
            reason = self.context.wire.explain(error)
            raise TransportError(f'{state.title}: zenoh refused a request: {reason}') from None
        return sequence

    def cancel(self, sequence: int) -> None:
        """Hold nothing for this request any more; a reply that is being handed over is waited for."""
        call = self.waiting.pop(sequence, None)
        if call is not None and call.asked is not None and not self.state.guard.is_forked:
            self._querier.cancel(call.asked)

    def leave(self) -> None:
        """Take the querier off the wire and end every call."""
        self._querier.undeclare()
        for call in list(self.waiting.values()):
            call.end()

    def reject(self, error: RemoteError | str) -> None:
        """Count a reply that cannot be used."""
        self.context.rejects.add('reply', error, self.state)
