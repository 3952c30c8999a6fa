"""Publishers and subscriptions of the memory transport.

All a publisher sends goes through its dispatcher, the history for a late subscription too: so each
subscription sees one publisher's messages in order, each once, whichever threads publish.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock
from time import time_ns

from goalwire.rules.qos import QoS
from goalwire.transport.contract import Port, PublisherPort, Sample
from goalwire.transport.failures import report_failure
from goalwire.transport.memory.endpoint_state import MemoryEndpointState
from goalwire.transport.ordered_dispatcher import OrderedDispatcher

_DEFAULT_DEPTH = 42
"""What rmw_zenoh takes for a depth of 0."""


def _history_length(qos: QoS) -> int:
    """Return how many samples a transient_local endpoint keeps or asks for: its depth, as in rmw_zenoh."""
    return (qos.depth or _DEFAULT_DEPTH) if qos.is_transient_local else 0


class MemorySubscription(Port):
    """A declared subscription."""

    def __init__(
        self, state: MemoryEndpointState, deliver: Callable[[Sample], None], *, ignore_local: bool = False
    ) -> None:
        self.state = state
        self.gid = state.entity.gid
        self._deliver = deliver
        self._ignore_local = ignore_local
        self.history_length = _history_length(state.entity.qos)

    def wants(self, publisher: MemoryPublisher) -> bool:
        """Return whether this publisher's messages are meant for us; QoS prevents nothing."""
        return not (self._ignore_local and publisher.state.entity.session == self.state.entity.session)

    def receive(self, sample: Sample) -> None:
        """Deliver one message, unless we have been closed meanwhile."""
        if self.state.closed:
            return
        try:
            self._deliver(sample)
        except Exception as error:
            report_failure(self.state.title, error)

    def close(self) -> None:
        """Undeclare."""
        self.state.close()


class MemoryPublisher(PublisherPort):
    """A declared publisher."""

    def __init__(self, state: MemoryEndpointState) -> None:
        self.state = state
        self.gid = state.entity.gid
        self._sequence = 0
        self._history: deque[Sample] = deque(maxlen=_history_length(state.entity.qos))
        self._targets: tuple[MemorySubscription, ...] = ()
        self._lock = Lock()
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
        self._dispatcher.drain()

    @staticmethod
    def _deliver(item: tuple[Sample, tuple[MemorySubscription, ...]]) -> None:
        sample, targets = item
        for target in targets:
            target.receive(sample)

    def connect(self, subscription: MemorySubscription) -> None:
        """Send to this subscription from now on, queueing the history it wants; `flush` delivers that."""
        with self._lock:
            self._targets += (subscription,)
            wanted = (
                list(self._history)[-subscription.history_length :] if subscription.history_length else []
            )
            now = time_ns()
            for sample in wanted:
                self._dispatcher.post((sample._replace(received_timestamp=now), (subscription,)))

    def disconnect(self, subscription: MemorySubscription) -> None:
        """Send no more to this subscription."""
        with self._lock:
            self._targets = tuple(target for target in self._targets if target is not subscription)

    def flush(self) -> None:
        """Deliver what is queued."""
        self._dispatcher.drain()

    def close(self) -> None:
        """Undeclare; the history goes with us."""
        self.state.close()
