"""The subscriptions by which a recorder hears one topic, whatever QoS its publishers have."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.recorded_calls import POSTFIX_FOR_RECORDERS
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy

if TYPE_CHECKING:
    from goalwire.aio import Node
    from goalwire.aio.raw import RawSubscription
    from goalwire.apps.bag.intake import Intake
    from goalwire.execution.clock import Clock
    from goalwire.transport.contract import GraphEntity, Sample

DEPTH = 1000
"""Of the recorder's subscriptions: history that is kept for it is not cut short."""
HELD = 1000
"""How many messages of a topic wait at most for the definition of its type."""


class Delivery:
    """Puts the messages of one topic into the file; they wait while the type's definition is looked for."""

    def __init__(self, intake: Intake, topic: str, clock: Clock | None) -> None:
        """Messages are stored under the name `topic`, with the time of `clock` if there is one."""
        self._intake = intake
        self.topic = topic
        self._clock = clock
        self._lock = Lock()
        self._is_open = False
        self._held: deque[tuple[Sample, int]] = deque()

    def open(self) -> None:
        """Begin to write: the waiting messages first. The file knows the topic by now."""
        with self._lock:
            while self._held:
                self._intake.put(self.topic, *self._held.popleft())
            self._is_open = True

    def take(self, sample: Sample) -> None:
        """Take one message; on any thread."""
        time = sample.received_timestamp if self._clock is None else self._clock.now().nanoseconds
        if not time:  # simulated time is 0 before the first /clock
            return
        if self._is_open or not self._has_held(sample, time):
            self._intake.put(self.topic, sample, time)

    def _has_held(self, sample: Sample, time: int) -> bool:
        """Keep a message until the topic is known to the file; False if it has become known meanwhile."""
        with self._lock:
            if self._is_open:
                return False
            if len(self._held) < HELD:
                self._held.append((sample, time))
            else:
                self._intake.drop(self.topic)
            return True


_Class = tuple[bool, bool]
"""Whether publishers are reliable, and whether they keep history."""


class TopicRecording:
    """The subscriptions of one topic.

    If the wire keeps endpoints apart whose QoS do not go together, no single subscription serves all
    publishers as well as they offer: one that takes best effort loses messages of reliable publishers, one
    that is reliable hears nothing of the others. So there is a subscription for each class of publishers, and
    each takes messages of its own class alone. On other wires reliability is the publisher's business, and
    only those with history are a class of their own.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        type_name: str,
        type_hash: str,
        delivery: Delivery,
        qos: QoS | None = None,
    ) -> None:
        self.name = name
        self.type_name = type_name
        self._node = node
        self.type_hash = type_hash
        self.delivery = delivery
        self._qos = qos
        self._owners: dict[bytes, _Class] = {}
        self._subscriptions: dict[_Class, RawSubscription] = {}

    @property
    def is_asked_for(self) -> bool:
        """Whether the messages are calls that are published since this recorder asks for them."""
        return self.name.endswith(POSTFIX_FOR_RECORDERS)

    def update(self, publishers: Iterable[GraphEntity]) -> None:
        """Subscribe with the QoS that these publishers need."""
        fitting = [each for each in publishers if each.type_name == self.type_name]
        if self._qos is not None:
            if not self._subscriptions:
                self._subscribe((True, True), self._qos, None)
            return
        enforces_qos = self._node.context.session.enforces_qos
        classes: dict[_Class, None] = {}
        for publisher in fitting:
            offered = publisher.qos.stated()
            found = offered.is_reliable and enforces_qos, offered.is_transient_local
            self._owners[publisher.gid] = found
            classes[found] = None
        for found in classes or {(enforces_qos, False): None}:
            if found not in self._subscriptions:
                self._subscribe(found, _qos_for(found), self._acceptor(found))

    def _acceptor(self, own: _Class) -> Callable[[bytes], bool]:
        owners = self._owners
        other = next(iter(self._subscriptions), own)
        """Takes the messages of publishers that the graph does not show: the first subscription."""
        return lambda gid: owners.get(gid, other) == own

    def _subscribe(self, kind: _Class, qos: QoS, accepts: Callable[[bytes], bool] | None) -> None:
        take = self.delivery.take

        def deliver(sample: Sample) -> None:
            if accepts is None or accepts(sample.gid):
                take(sample)

        self._subscriptions[kind] = self._node.raw_subscription(
            self.name, self.type_name, deliver, type_hash=self.type_hash, qos=qos
        )

    def close(self) -> None:
        """Unsubscribe."""
        for subscription in self._subscriptions.values():
            subscription.close()


def _qos_for(kind: _Class) -> QoS:
    is_reliable, has_history = kind
    return QoS(
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if has_history else DurabilityPolicy.VOLATILE,
    )
