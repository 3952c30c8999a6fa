"""The subscriptions of a recorder to one topic, for publishers of any QoS."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from threading import Lock
from typing import TYPE_CHECKING

from goalwire.entities.recorder_watch import POSTFIX_FOR_RECORDERS
from goalwire.rules.qos import DurabilityPolicy, QoS, ReliabilityPolicy

if TYPE_CHECKING:
    from goalwire.aio import Node
    from goalwire.aio.raw import RawSubscription
    from goalwire.apps.bag.intake import Intake
    from goalwire.execution.time.clock import Clock
    from goalwire.transport.contract import GraphEntity, Sample

DEPTH = 1000
"""Queue depth of the recorder's subscriptions, large enough for the history of publishers."""
HELD = 1000
"""The most messages of a topic that wait for the definition of its type."""


class Delivery:
    """Puts the messages of one topic into the file. They wait until the type's definition is found."""

    def __init__(self, intake: Intake, topic: str, clock: Clock | None) -> None:
        """Messages are stored under the name `topic`, with the time of `clock` if there is one."""
        self._intake = intake
        self.topic = topic
        self._clock = clock
        self._lock = Lock()
        self._is_open = False
        self._held: deque[tuple[Sample, int]] = deque()

    def open(self) -> None:
        """Begin to write, the waiting messages first. The topic must have been added to the file."""
        with self._lock:
            while self._held:
                self._intake.put(self.topic, *self._held.popleft())
            self._is_open = True

    def take(self, sample: Sample) -> None:
        """Take one message. May be called on any thread."""
        time = sample.received_timestamp if self._clock is None else self._clock.now().nanoseconds
        if not time:  # simulated time is 0 before the first /clock
            return
        if self._is_open or not self._has_held(sample, time):
            self._intake.put(self.topic, sample, time)

    def _has_held(self, sample: Sample, time: int) -> bool:
        """Keep a message until `open` is called; return False if `open` was called meanwhile."""
        with self._lock:
            if self._is_open:
                return False
            if len(self._held) < HELD:
                self._held.append((sample, time))
            else:
                self._intake.drop(self.topic)
            return True


_Class = tuple[bool, bool]
"""A class of publishers by QoS: whether they are reliable, and whether they are transient local."""


class TopicRecording:
    """The subscriptions of one topic.

    If the wire does not connect endpoints of incompatible QoS, one subscription is not enough: with best
    effort it may lose messages of reliable publishers, and a reliable one gets nothing from best-effort ones.
    So each class of publishers has a subscription, which takes only messages of its own class. On other
    wires the publisher decides the reliability, and only publishers with history are a separate class.
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
        """True if the messages are calls that are published only because this recorder asks for them."""
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
        """The class whose subscription takes the messages of publishers that the graph does not show."""
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
