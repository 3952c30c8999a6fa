"""Ports that apply the faults of a plan to the packets of a wire.

Faults are applied to messages and requests where they arrive, and to replies where they are sent. If a
partition hides every server of a client, the client's calls end.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING, Generic, TypeVar

from goalwire.errors import LocalError
from goalwire.fault_reports import report_failure
from goalwire.rules.qos_events import PublisherEvent, SubscriptionEvent
from goalwire.transport.contract import ClientPort, Loan, Port, PublisherPort, Request, Sample
from goalwire.transport.faults.kinds import Kind, Moment, Packet
from goalwire.transport.faults.plan import Plan

if TYPE_CHECKING:
    from goalwire.rules.qos_events import EventStatus, EventType

T = TypeVar('T', Sample, Request)

_MATCHED = {PublisherEvent.RCL_PUBLISHER_MATCHED, SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED}


class FaultyPort(Port):
    """The base class of the ports: it holds the wire's own port and the plan of faults."""

    _inner: Port
    faults: Plan

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Watch an event of the wire. Matches are watched in the graph, which knows what the faults hide."""
        self.faults.call('port.watch_event')
        return event not in _MATCHED and self._inner.watch_event(event, changed)

    def peer_count(self) -> None:
        """Return None: matches are counted in the graph, as for the event of matches."""

    def close(self) -> None:
        """Undeclare."""
        self._inner.close()
        self.faults.call('port.close')


class ReceivingPort(FaultyPort, Generic[T]):
    """A port that receives messages or requests. Closing it drops the packets under way."""

    kind: Kind

    def __init__(
        self,
        declare: Callable[[Callable[[T], None]], Port],
        deliver: Callable[[T], None],
        name: str,
        node: str,
        faults: Plan,
        owner_of: Callable[[bytes], str],
    ) -> None:
        """`declare` makes the wire's port; `owner_of` returns the node of an endpoint by its gid."""
        self.name = name
        self.node = node
        self.faults = faults
        self._deliver: Callable[[T], None] = deliver
        self._owner_of = owner_of
        self._is_closed = False
        self._inner = declare(self._receive)
        self.gid = self._inner.gid

    @abstractmethod
    def _receive(self, arrived: T) -> None:
        """Take a message or request that the wire delivers."""

    def _send_on(self, sample: Sample, source: str, deliver: Callable[[Sample], None]) -> bool:
        """Deliver a sample from the node `source` as the faults change it; False if nothing is delivered."""
        packet = Packet(self.kind, self.name, source, self.node, sample.payload)

        def arrive(result: Packet) -> None:
            if not self._is_closed:
                received = sample.received_timestamp + result.delay_ns
                deliver(sample._replace(payload=result.payload, received_timestamp=received))

        return self.faults.passes(Moment.ARRIVED, packet) and self.faults.send(packet, arrive)

    def close(self) -> None:
        """Undeclare the port. Packets under way are dropped."""
        self._is_closed = True
        super().close()


class FaultyPublisher(FaultyPort, PublisherPort):
    """A publisher. Faults are applied to its messages where they arrive."""

    _inner: PublisherPort

    def __init__(self, inner: PublisherPort, name: str, node: str, faults: Plan) -> None:
        self._inner = inner
        self.gid = inner.gid
        self._name = name
        self._node = node
        self.faults = faults

    @property
    def dropped(self) -> int:
        """How many messages the wire itself dropped here."""
        return self._inner.dropped

    def publish(self, payload: bytes) -> None:
        """Send one message; drop it if the node is dead."""
        self.faults.call('publisher.publish')
        packet = Packet(Kind.MESSAGE, self._name, self._node, '', payload)
        if self.faults.passes(Moment.SENDING, packet):
            self._inner.publish(payload)
            self.faults.passes(Moment.SENT, packet)

    def borrow(self, size: int) -> None:  # noqa: ARG002
        """Lend no memory: faults change a message's bytes, so each message is sent as bytes."""
        self.faults.call('publisher.borrow')

    def publish_loan(self, loan: Loan) -> None:
        """Send the message that was written into a loan, as `publish` does."""
        self.publish(bytes(loan.view))

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive."""
        self.faults.call('publisher.assert_liveliness')
        self._inner.assert_liveliness()

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait for the wire's acknowledgements. Faults do not delay these."""
        self.faults.call('publisher.wait_for_acknowledgements')
        return self._inner.wait_for_acknowledgements(timeout_ns)


class FaultySubscription(ReceivingPort[Sample]):
    """A subscription, which applies the faults to arriving messages."""

    kind = Kind.MESSAGE

    def _receive(self, arrived: Sample) -> None:
        self._send_on(arrived, self._owner_of(arrived.gid), self._deliver)

    def catch_up(self) -> None:
        """Deliver the messages that have arrived by now."""
        self._inner.catch_up()


class FaultyCall:
    """One request that waits. It ends once: by the wire, or because its servers are hidden."""

    def __init__(
        self, client: FaultyClient, on_reply: Callable[[Sample], None], on_end: Callable[[str], None]
    ) -> None:
        self._client = client
        self._on_reply = on_reply
        self._on_end = on_end
        self.sequence = 0
        self.is_over = False

    def on_reply(self, sample: Sample) -> None:
        """Give a reply to the caller, unless the call has ended."""
        if not self.is_over:
            self._on_reply(sample)

    def on_end(self, reason: str) -> None:
        """End the call; only the first time has an effect."""
        if self._client.ended(self):
            self._on_end(reason)


class FaultyClient(FaultyPort, ClientPort):
    """A service client, with faults. `is_blind` returns True if faults hide its servers."""

    _inner: ClientPort

    def __init__(self, inner: ClientPort, faults: Plan, is_blind: Callable[[], bool]) -> None:
        self._inner = inner
        self.gid = inner.gid
        self.faults = faults
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
        self.faults.call('client.request')
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
        """Mark a call as ended; return False if it had ended before."""
        with self._lock:
            was_over, call.is_over = call.is_over, True
            self._calls.pop(call.sequence, None)
        return not was_over

    def cancel(self, sequence: int) -> None:
        """Forget this request."""
        self.faults.call('client.cancel')
        with self._lock:
            call = self._calls.pop(sequence, None)
            if call is not None:
                call.is_over = True
        self._inner.cancel(sequence)

    def look_again(self) -> None:
        """End the calls of a client whose servers are hidden now."""
        if not self._is_blind():
            return
        with self._lock:
            calls = list(self._calls.values())
        for call in calls:
            self._end(call)

    def _end(self, call: FaultyCall) -> None:
        """End a call that the wire has not ended yet."""
        try:
            call.on_end('')
        except Exception as error:
            report_failure('client under faults', error)
        self._inner.cancel(call.sequence)

    def reaches_server(self) -> bool:
        """Return whether a server that the graph shows can be called now."""
        self.faults.call('client.reaches_server')
        return self._inner.reaches_server()


_KEPT = 10_000
"""How many unanswered requests are kept. Beyond this the oldest is cancelled."""


class FaultyService(ReceivingPort[Request]):
    """A service server, which applies the faults to requests and their replies."""

    kind = Kind.REQUEST

    def __init__(
        self,
        declare: Callable[[Callable[[Request], None]], Port],
        deliver: Callable[[Request], None],
        name: str,
        node: str,
        faults: Plan,
        owner_of: Callable[[bytes], str],
    ) -> None:
        self._lost: deque[Request] = deque()
        super().__init__(declare, deliver, name, node, faults, owner_of)

    def _receive(self, arrived: Request) -> None:
        arrival = Arrival(self, arrived, self._owner_of(arrived.sample.gid))
        if not self._send_on(
            arrived.sample, arrival.client, lambda sample: self._deliver(FaultyRequest(arrival, sample))
        ):
            self.keep(arrived)

    def keep(self, request: Request) -> None:
        """Keep a request that is lost, and do not cancel it: its client must not learn of the loss."""
        self._lost.append(request)
        if len(self._lost) > _KEPT:
            self._lost.popleft().cancel()

    def close(self) -> None:
        """Undeclare the port. Packets under way are dropped."""
        super().close()
        self._lost.clear()


class Arrival:
    """One request of the wire, which may have arrived several times and is answered once."""

    def __init__(self, service: FaultyService, inner: Request, client: str) -> None:
        self.inner = inner
        self._service = service
        self.client = client
        """The node that sent the request."""
        self._lock = Lock()
        self._copies = 0
        self._is_answered = False

    def note_copy(self) -> None:
        """Count one more copy of the request that the server holds."""
        with self._lock:
            self._copies += 1

    def reply(self, payload: bytes) -> None:
        """Send the first answer; ignore any other, as a client would."""
        service = self._service
        service.faults.call('request.reply')
        with self._lock:
            was_answered, self._is_answered = self._is_answered, True
        if was_answered:
            return
        packet = Packet(Kind.REPLY, service.name, service.node, self.client, payload)
        is_alive = service.faults.passes(Moment.SENDING, packet)
        if not (is_alive and service.faults.send(packet, self._send)):
            service.keep(self.inner)

    def _send(self, packet: Packet) -> None:
        self.inner.reply(bytes(packet.payload))
        self._service.faults.passes(Moment.SENT, packet)

    def cancel(self, reason: str) -> None:
        """Cancel one copy. When no other copy can be answered, cancel the request on the wire."""
        service = self._service
        service.faults.call('request.cancel')
        with self._lock:
            self._copies -= 1
            is_over = self._copies == 0 and not self._is_answered
        if is_over:
            # The reason travels as a reply does, but without a payload that a fault could change.
            packet = Packet(Kind.REPLY, service.name, service.node, self.client, b'')
            if not service.faults.send(packet, lambda _: self.inner.cancel(reason)):
                service.keep(self.inner)


class FaultyRequest(Request):
    """A request as its server sees it."""

    __slots__ = ('_arrival', '_is_answered', 'sample')

    def __init__(self, arrival: Arrival, sample: Sample) -> None:
        self.sample = sample
        self._arrival = arrival
        self._is_answered = False
        arrival.note_copy()

    def reply(self, payload: bytes) -> None:
        """Answer. Raises LocalError the second time."""
        if self._is_answered:
            raise LocalError('this request was answered before; answer it once')
        self._is_answered = True
        self._arrival.reply(payload)

    def cancel(self, reason: str = '') -> None:
        """Give the request up; harmless after an answer."""
        if not self._is_answered:
            self._is_answered = True
            self._arrival.cancel(reason)
