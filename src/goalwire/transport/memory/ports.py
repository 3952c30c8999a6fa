"""Publishers, subscriptions, servers and clients of the memory transport.

Everything that a publisher sends goes through its dispatcher, also the history for a late subscription. So
each subscription gets a publisher's messages in order, and each once, whichever threads publish.

A call is handed to every server that is there at that moment. The call ends when each server has
answered, cancelled its request, or gone; or when the client closes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock, RLock
from time import time_ns

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.fault_reports import report_failure
from goalwire.rules.qos import QoS
from goalwire.transport.contract import ClientPort, GraphEntity, PublisherPort, Request, Sample
from goalwire.transport.endpoint import EndpointState, OpenPort, answered_before

_DEFAULT_DEPTH = 42
"""The depth that rmw_zenoh uses if the QoS has depth 0."""


def _history_length(qos: QoS) -> int:
    """Return how many samples a transient_local endpoint keeps or asks for: its depth, as in rmw_zenoh."""
    return (qos.depth or _DEFAULT_DEPTH) if qos.is_transient_local else 0


class MemorySubscription(OpenPort):
    """A declared subscription."""

    def __init__(
        self,
        state: EndpointState,
        entity: GraphEntity,
        deliver: Callable[[Sample], None],
        *,
        ignore_local: bool,
    ) -> None:
        super().__init__(state, entity.gid)
        self.entity = entity
        self._deliver = deliver
        self._ignore_local = ignore_local
        self.history_length = _history_length(entity.qos)

    def wants(self, publisher: MemoryPublisher) -> bool:
        """Return whether this subscription takes a publisher's messages; QoS prevents nothing."""
        return not (self._ignore_local and publisher.entity.session == self.entity.session)

    def receive(self, sample: Sample) -> None:
        """Deliver one message, unless the subscription has been closed meanwhile."""
        if self.state.closed:
            return
        try:
            self._deliver(sample)
        except Exception as error:
            report_failure(self.state.title, error)


class MemoryPublisher(OpenPort, PublisherPort):
    """A declared publisher."""

    def __init__(self, state: EndpointState, entity: GraphEntity) -> None:
        super().__init__(state, entity.gid)
        self.entity = entity
        self._sequence = 0
        self._history: deque[Sample] = deque(maxlen=_history_length(entity.qos))
        self._targets: tuple[MemorySubscription, ...] = ()
        self._lock = RLock()  # reentrant: a signal handler may publish while its thread publishes
        self._delivering = RLock()
        """Held while messages are delivered. A thread that publishes waits for another one that delivers:
        whatever it sends next, a service's reply for example, must not overtake this message."""
        self._dispatcher: OrderedDispatcher[tuple[Sample, tuple[MemorySubscription, ...]]] = (
            OrderedDispatcher(self._deliver)
        )

    def publish(self, payload: bytes) -> None:
        """Deliver one message to every matched subscription."""
        self.state.check_sending()
        payload = bytes(payload)
        with self._lock:
            self._sequence += 1
            now = time_ns()
            sample = Sample(payload, self._sequence, now, now, self.gid)
            self._history.append(sample)
            if self._targets:
                self._dispatcher.post((sample, self._targets))
        self.flush()

    @staticmethod
    def _deliver(item: tuple[Sample, tuple[MemorySubscription, ...]]) -> None:
        sample, targets = item
        for target in targets:
            target.receive(sample)

    def connect(self, subscription: MemorySubscription) -> None:
        """Send to this subscription from now on, and queue the history that it wants for `flush`."""
        with self._lock:
            self._targets += (subscription,)
            wanted = (
                list(self._history)[-subscription.history_length :] if subscription.history_length else []
            )
            now = time_ns()
            for sample in wanted:
                self._dispatcher.post((sample._replace(received_timestamp=now), (subscription,)))

    def disconnect(self, subscription: MemorySubscription) -> None:
        """Stop sending to this subscription."""
        with self._lock:
            self._targets = tuple(target for target in self._targets if target is not subscription)

    def flush(self) -> None:
        """Deliver the queued messages, or wait until another thread has delivered them."""
        with self._delivering:
            self._dispatcher.drain()


def _to_nobody(_: object) -> None:
    """Do nothing; stands in for the functions of a caller that has cancelled its request."""


class MemoryCall:
    """One call on the client's side, with a request for each server."""

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
        """The call's requests, one for each server."""

    def answered(self, sample: Sample) -> None:
        """Give one server's reply to the caller, and count this server as done."""
        if self._open > 0:
            self._client.run(self._on_reply, sample)
        self.server_done()

    def server_done(self, reason: str = '') -> None:
        """Count one server as done. `on_end` is called after the last one, and so after every reply."""
        with self._lock:
            self._reason = self._reason or reason
            self._open -= 1
            is_last = self._open == 0
        if is_last:
            self._end()

    def cancel(self) -> None:
        """Ignore further answers, and let the servers forget the call's requests."""
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
            for request in list(self.requests):
                request.discard()
            self._end()

    def _end(self) -> None:
        """End the call: no server has its request any more."""
        self._client.waiting.pop(self._sequence, None)
        self.requests.clear()
        self._client.run(self._on_end, self._reason)


class MemoryRequest(Request):
    """The request of a call to one server."""

    __slots__ = ('_call', '_is_answered', '_server', 'sample')

    def __init__(self, server: MemoryService, call: MemoryCall, sample: Sample) -> None:
        self.sample = sample
        self._server = server
        self._call = call
        self._is_answered = False

    def reply(self, payload: bytes) -> None:
        """Answer on this thread. Raises LocalError the second time. A caller that has gone is ignored."""
        if self._is_answered:
            raise answered_before(self._server.state)
        self._is_answered = True
        if self._server.discard(self):
            now = time_ns()
            self._call.answered(Sample(bytes(payload), self.sample.sequence, now, now, self.sample.gid))

    def discard(self) -> None:
        """Forget the request: nobody waits for the answer any more."""
        self._server.discard(self)

    def cancel(self, reason: str = '') -> None:
        """End the request without an answer. Does nothing after an answer."""
        if self._server.discard(self):
            self._call.server_done(reason)


class MemoryService(OpenPort):
    """A declared service server."""

    def __init__(self, state: EndpointState, entity: GraphEntity, deliver: Callable[[Request], None]) -> None:
        super().__init__(state, entity.gid)
        self.entity = entity
        self._deliver = deliver
        self._lock = Lock()
        self._waiting: set[MemoryRequest] = set()

    def accept(self, call: MemoryCall, sample: Sample) -> None:
        """Deliver the request of a call. If the server has closed, or fails, the request ends at once."""
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
        """Remove a request; return True only to the caller that has removed it."""
        with self._lock:
            if request in self._waiting:
                self._waiting.remove(request)
                return True
            return False

    def cancel_all(self) -> None:
        """End every unanswered request."""
        with self._lock:
            waiting = list(self._waiting)
        for request in waiting:
            request.cancel()


class MemoryClient(OpenPort, ClientPort):
    """A declared service client."""

    def __init__(
        self, state: EndpointState, entity: GraphEntity, servers: Callable[[], tuple[MemoryService, ...]]
    ) -> None:
        super().__init__(state, entity.gid)
        self._servers = servers
        self._lock = Lock()
        self._sequence = 0
        self.waiting: dict[int, MemoryCall] = {}
        """The requests that have not ended, by their sequence numbers."""

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,  # noqa: ARG002 - it is cancelled in time
    ) -> int:
        """Deliver a request to every server, on this thread."""
        self.state.check_sending()
        payload = bytes(payload)
        servers = self._servers()
        with self._lock:
            self._sequence += 1
            sequence = self._sequence
            call = MemoryCall(self, sequence, len(servers), on_reply, on_end)
            if servers:
                self.waiting[sequence] = call
        if not servers:
            self.run(on_end, '')
            return sequence
        # The client may have been closed after the check above: then `close` may have missed this call.
        if self.state.closed:
            call.close()
        now = time_ns()
        for server in servers:
            server.accept(call, Sample(payload, sequence, now, now, self.gid))
        return sequence

    def run(self, callback: Callable[..., None], *arguments: Sample | str) -> None:
        """Run a caller's function on the server's thread; log its errors."""
        try:
            callback(*arguments)
        except Exception as error:
            report_failure(self.state.title, error)

    def cancel(self, sequence: int) -> None:
        """Forget a call. One that has ended is ignored."""
        call = self.waiting.pop(sequence, None)
        if call is not None:
            call.cancel()

    def close_calls(self) -> None:
        """End every call."""
        with self._lock:
            calls = list(self.waiting.values())
        for call in calls:
            call.close()
