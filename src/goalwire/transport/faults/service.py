"""Service servers, with faults: requests meet them where they arrive, replies where they are sent."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.errors import LocalError
from goalwire.transport.contract import Port, Request, Sample
from goalwire.transport.faults.kill import Moment
from goalwire.transport.faults.packet import Kind, Packet
from goalwire.transport.faults.plan import Faults

if TYPE_CHECKING:
    from goalwire.rules.qos_events import EventStatus, EventType

_KEPT = 10_000
"""How many requests without an answer are remembered; the oldest is then given up."""


class FaultyService(Port):
    """A service server, with faults."""

    def __init__(
        self,
        declare: Callable[[Callable[[Request], None]], Port],
        deliver: Callable[[Request], None],
        name: str,
        node: str,
        faults: Faults,
        owner_of: Callable[[bytes], str],
    ) -> None:
        self._deliver = deliver
        self.name = name
        self.node = node
        self.faults = faults
        self._owner_of = owner_of
        self._is_closed = False
        self._lost: deque[Request] = deque()
        self._inner = declare(self._receive)
        self.gid = self._inner.gid

    def _receive(self, request: Request) -> None:
        client = self._owner_of(request.sample.gid)
        arrival = Arrival(self, request, client)
        packet = Packet(Kind.REQUEST, self.name, client, self.node, request.sample.payload)
        if not (
            self.faults.passes(Moment.ARRIVED, packet)
            and self.faults.send(packet, lambda result: self._arrive(arrival, result))
        ):
            self.keep(request)

    def _arrive(self, arrival: Arrival, result: Packet) -> None:
        sample = arrival.inner.sample
        received = sample.received_timestamp + result.delay_ns
        if not self._is_closed:
            sample = sample._replace(payload=result.payload, received_timestamp=received)
            self._deliver(FaultyRequest(arrival, sample))

    def keep(self, request: Request) -> None:
        """Keep a request that will not be answered: where it was lost, nobody tells its client."""
        self._lost.append(request)
        if len(self._lost) > _KEPT:
            self._lost.popleft().cancel()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Watch what the wire finds out itself."""
        self.faults.call('port.watch_event')
        return self._inner.watch_event(event, changed)

    def close(self) -> None:
        """Undeclare; what is under way is lost."""
        self._is_closed = True
        self._inner.close()
        self._lost.clear()
        self.faults.call('port.close')


class Arrival:
    """One request of the wire, which may have arrived several times and is answered once."""

    def __init__(self, service: FaultyService, inner: Request, client: str) -> None:
        self.inner = inner
        self._service = service
        self._client = client
        self._lock = Lock()
        self._copies = 0
        self._is_answered = False

    def copied(self) -> None:
        """One more is with the server."""
        with self._lock:
            self._copies += 1

    def reply(self, payload: bytes) -> None:
        """Send the first answer; a client ignores any other, as the wire's would."""
        service = self._service
        service.faults.call('request.reply')
        with self._lock:
            was_answered, self._is_answered = self._is_answered, True
        if was_answered:
            return
        packet = Packet(Kind.REPLY, service.name, service.node, self._client, payload)
        is_alive = service.faults.passes(Moment.SENDING, packet)
        if not (is_alive and service.faults.send(packet, self._send)):
            service.keep(self.inner)

    def _send(self, packet: Packet) -> None:
        self.inner.reply(bytes(packet.payload))
        self._service.faults.passes(Moment.SENT, packet)

    def cancel(self, reason: str) -> None:
        """Give it up, once nobody has a copy that may be answered yet."""
        service = self._service
        service.faults.call('request.cancel')
        with self._lock:
            self._copies -= 1
            is_over = self._copies == 0 and not self._is_answered
        if is_over:
            # The reason travels as a reply does, without a content that a fault could change.
            packet = Packet(Kind.REPLY, service.name, service.node, self._client, b'')
            if not service.faults.send(packet, lambda _: self.inner.cancel(reason)):
                service.keep(self.inner)


class FaultyRequest(Request):
    """A request as its server sees it."""

    __slots__ = ('_arrival', '_is_answered', 'sample')

    def __init__(self, arrival: Arrival, sample: Sample) -> None:
        self.sample = sample
        self._arrival = arrival
        self._is_answered = False
        arrival.copied()

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
