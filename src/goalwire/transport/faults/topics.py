"""Publishers and subscriptions, with faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from goalwire.transport.contract import Port, PublisherPort, Sample
from goalwire.transport.faults.kill import Moment
from goalwire.transport.faults.packet import Kind, Packet
from goalwire.transport.faults.plan import Faults

if TYPE_CHECKING:
    from goalwire.rules.qos_events import EventStatus, EventType


class FaultyPublisher(PublisherPort):
    """A publisher; its messages meet their faults where they arrive."""

    def __init__(self, inner: PublisherPort, name: str, node: str, faults: Faults) -> None:
        self._inner = inner
        self.gid = inner.gid
        self._name = name
        self._node = node
        self._faults = faults

    @property
    def dropped(self) -> int:
        """What the wire itself dropped here."""
        return self._inner.dropped

    def publish(self, payload: bytes) -> None:
        """Send one message; that of a dead node goes nowhere."""
        self._faults.call('publisher.publish')
        packet = Packet(Kind.MESSAGE, self._name, self._node, '', payload)
        if self._faults.passes(Moment.SENDING, packet):
            self._inner.publish(payload)
            self._faults.passes(Moment.SENT, packet)

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive."""
        self._faults.call('publisher.assert_liveliness')
        self._inner.assert_liveliness()

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait for the wire's acknowledgements, which know nothing of faults."""
        self._faults.call('publisher.wait_for_acknowledgements')
        return self._inner.wait_for_acknowledgements(timeout_ns)

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Watch what the wire finds out itself."""
        self._faults.call('port.watch_event')
        return self._inner.watch_event(event, changed)

    def close(self) -> None:
        """Undeclare."""
        self._inner.close()
        self._faults.call('port.close')


class FaultySubscription(Port):
    """A subscription: here messages meet their faults."""

    def __init__(
        self,
        declare: Callable[[Callable[[Sample], None]], Port],
        deliver: Callable[[Sample], None],
        name: str,
        node: str,
        faults: Faults,
        owner_of: Callable[[bytes], str],
    ) -> None:
        self._deliver = deliver
        self._name = name
        self._node = node
        self._faults = faults
        self._owner_of = owner_of
        self._is_closed = False
        self._inner = declare(self._receive)
        self.gid = self._inner.gid

    def _receive(self, sample: Sample) -> None:
        source = self._owner_of(sample.gid)
        packet = Packet(Kind.MESSAGE, self._name, source, self._node, sample.payload)
        if self._faults.passes(Moment.ARRIVED, packet):
            self._faults.send(packet, lambda result: self._arrive(sample, result))

    def _arrive(self, sample: Sample, result: Packet) -> None:
        if not self._is_closed:
            received = sample.received_timestamp + result.delay_ns
            self._deliver(sample._replace(payload=result.payload, received_timestamp=received))

    def catch_up(self) -> None:
        """Deliver what has arrived by now."""
        self._inner.catch_up()

    def watch_event(self, event: EventType, changed: Callable[[EventStatus], None]) -> bool:
        """Watch what the wire finds out itself."""
        self._faults.call('port.watch_event')
        return self._inner.watch_event(event, changed)

    def close(self) -> None:
        """Undeclare; what is under way is lost."""
        self._is_closed = True
        self._inner.close()
        self._faults.call('port.close')
