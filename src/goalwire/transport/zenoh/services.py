"""Service clients and servers on Zenoh, which number requests and match replies to them.

A request is a query. A server is a complete queryable that keeps each request until it is answered.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from threading import RLock
from time import time_ns

from goalwire.errors import RemoteError, TransportError, peer_text
from goalwire.rules.reasons import CLOSING
from goalwire.transport.contract import ClientPort, Request, Sample
from goalwire.transport.endpoint import EndpointState, OpenPort, answered_before
from goalwire.transport.zenoh.attachment import GID_SIZE, encode, sample_of
from goalwire.transport.zenoh.context import ZenohContext
from goalwire.transport.zenoh.wire import Declared, Message, Querier
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import ReplyError


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
        """The wire's handle of the query; None until it was sent."""

    def answered(self, answer: Message | ReplyError) -> None:
        """Deliver a reply. Runs on the wire's thread, or on the caller's within one session."""
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
        """End the call, since no reply can come any more or the client closes. Later calls do nothing."""
        if self._client.waiting.pop(self._sequence, None) is not None:  # only one thread gets here
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
            state.check()  # another thread may have closed the client in the meantime
            reason = self.context.wire.explain(error)
            raise TransportError(f'{state.title}: zenoh refused a request: {reason}') from None
        return sequence

    def cancel(self, sequence: int) -> None:
        """Forget a request. If a reply is being delivered, wait for that."""
        call = self.waiting.pop(sequence, None)
        if call is not None and call.asked is not None and not self.state.guard.is_forked:
            self._querier.cancel(call.asked)

    def leave(self) -> None:
        """Undeclare the querier, and end every call."""
        self._querier.undeclare()
        for call in list(self.waiting.values()):
            call.end()

    def reject(self, error: RemoteError | str) -> None:
        """Count a reply that cannot be used."""
        self.context.rejects.add('reply', error, self.state)


class ZenohRequest(Request):
    """One query on its way through the server."""

    __slots__ = ('_is_answered', '_query', '_service', 'sample')

    def __init__(self, service: ZenohService, query: Query, sample: Sample) -> None:
        self.sample = sample
        self._service = service
        self._query = query
        self._is_answered = False

    def reply(self, payload: bytes) -> None:
        """Answer on the server's own key. Raises LocalError the second time, ForkedError after a fork."""
        service = self._service
        if self._is_answered:
            raise answered_before(service.state)
        self._is_answered = True
        if not service.discard(self):
            return  # the server has closed or dropped the request: the client knows
        _, sequence, _, _, gid = self.sample
        attachment = encode(sequence, time_ns(), GID_SIZE, gid)
        try:
            self._query.answer(service.key, payload, attachment)
        except service.context.errors as error:
            service.context.rejects.add('reply', service.context.wire.explain(error), service.state)

    def cancel(self, reason: str = '') -> None:
        """End the request, with an error reply if there is a reason. Does nothing after an answer."""
        if not self._service.discard(self):
            return
        context = self._service.context
        try:
            if reason:
                self._query.reply_error(reason.encode())
            self._query.end()
        except context.errors as error:
            context.rejects.add('reply', context.wire.explain(error), self._service.state)


class ZenohService(OpenPort):
    """A declared service server."""

    def __init__(
        self,
        context: ZenohContext,
        state: EndpointState,
        key: str,
        gid: bytes,
        deliver: Callable[[Request], None],
    ) -> None:
        super().__init__(state, gid)
        self.context = context
        self.key = key
        self._deliver = deliver
        self._lock = RLock()
        self._is_open = True
        self._waiting: dict[tuple[bytes, int], ZenohRequest] = {}

    def declare(self) -> Declared:
        """Declare the queryable, which lets requests in."""
        return self.context.wire.declare_queryable(self.key, self._on_query)

    def _on_query(self, query: Query) -> None:
        """Add a query to the requests and deliver it; refuse one that breaks the rules."""
        try:
            sample = sample_of(query)
        except RemoteError as error:
            self._refuse(query, str(error))
            return
        request = ZenohRequest(self, query, sample)
        _, sequence, _, _, gid = sample
        call = gid, sequence
        with self._lock:
            is_admitted = self._is_open and call not in self._waiting
            if is_admitted:
                self._waiting[call] = request
        if not is_admitted:
            again = f'request {sequence} of client {gid.hex()} is being worked on already'
            self._refuse(query, again if self._is_open else CLOSING)
            return
        try:
            self._deliver(request)
        except BaseException:
            request.cancel()
            raise  # the wire logs the error

    def _refuse(self, query: Query, reason: str) -> None:
        self.context.rejects.add('request', reason, self.state)
        query.reply_error(reason.encode())
        query.end()

    def discard(self, request: ZenohRequest) -> bool:
        """Remove a request; return True only to the caller that has removed it."""
        if self.state.guard.is_forked:
            self.state.check()
        _, sequence, _, _, gid = request.sample
        call = gid, sequence
        with self._lock:
            if self._waiting.get(call) is not request:
                return False
            return self._waiting.pop(call, None) is not None  # a signal handler may have removed it meanwhile

    def cancel_all(self) -> None:
        """Undeclare the queryable, and end every unanswered request."""
        with self._lock:
            self._is_open = False
            waiting = list(self._waiting.values())
        for request in waiting:
            request.cancel()
