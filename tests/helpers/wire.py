"""Two ends of a wire for tests: sessions, a node in each, and what each sees of the graph."""

from __future__ import annotations

import threading
from collections.abc import Callable

from helpers.collector import Collector

from goalwire.protocol.qos import QoS
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    EndpointKind,
    GraphEntity,
    GraphListener,
    NodeName,
    Port,
    PublisherPort,
    Request,
    Sample,
    Session,
)

HASH = f'RIHS01_{"a1" * 32}'
OTHER_HASH = f'RIHS01_{"b2" * 32}'
STRING = 'std_msgs/msg/String'
ADD = 'example_interfaces/srv/AddTwoInts'
PATIENCE = 10.0
"""Seconds that only failures take."""


def topic_endpoint(
    kind: EndpointKind,
    name: str,
    qos: QoS | None = None,
    *,
    type_name: str = STRING,
    type_hash: str = HASH,
    ignore_local: bool = False,
) -> Endpoint:
    """Describe a publisher or subscription."""
    return Endpoint(kind, name, type_name, type_hash, qos or QoS(), ignore_local=ignore_local)


def service_endpoint(kind: EndpointKind, name: str) -> Endpoint:
    """Describe a service or client."""
    return Endpoint(kind, name, ADD, HASH, QoS())


class SeenGraph(GraphListener):
    """What a session has been told of the graph, to be waited on."""

    def __init__(self) -> None:
        self._entities: dict[tuple[str, int, bytes, EndpointKind], GraphEntity] = {}
        self._changed = threading.Condition()

    def appeared(self, entity: GraphEntity) -> None:
        with self._changed:
            self._entities[entity.session, entity.node_id, entity.gid, entity.kind] = entity
            self._changed.notify_all()

    def vanished(self, entity: GraphEntity) -> None:
        with self._changed:
            self._entities.pop((entity.session, entity.node_id, entity.gid, entity.kind), None)
            self._changed.notify_all()

    def now(self, kind: EndpointKind | None = None, name: str = '') -> list[GraphEntity]:
        """Return what is there at this moment; a node is asked for by its qualified name."""
        with self._changed:
            return self._find(kind, name)

    def _find(self, kind: EndpointKind | None, name: str) -> list[GraphEntity]:
        return [
            entity
            for entity in self._entities.values()
            if kind in {None, entity.kind} and name in {'', entity.name or entity.node.qualified}
        ]

    def expect(self, kind: EndpointKind, name: str, number: int = 1) -> list[GraphEntity]:
        """Wait until exactly `number` entities of that kind and name are there."""
        with self._changed:
            came = self._changed.wait_for(lambda: len(self._find(kind, name)) == number, PATIENCE)
            found = self._find(kind, name)
            seen = list(self._entities.values())
        assert came, f'{len(found)} instead of {number} of {kind.value} {name}; the graph shows {seen}'
        return found


class Side:
    """One session with one node."""

    def __init__(self, session: Session, node_name: str) -> None:
        self.session = session
        self.graph = SeenGraph()
        session.watch_graph(self.graph)
        self.node = session.node(NodeName(node_name))

    def publisher(self, name: str, qos: QoS | None = None, *, type_hash: str = HASH) -> PublisherPort:
        """Declare a publisher."""
        return self.node.publisher(topic_endpoint(EndpointKind.PUBLISHER, name, qos, type_hash=type_hash))

    def subscription(
        self,
        name: str,
        deliver: Callable[[Sample], None],
        qos: QoS | None = None,
        *,
        ignore_local: bool = False,
    ) -> Port:
        """Declare a subscription."""
        kind = EndpointKind.SUBSCRIPTION
        return self.node.subscription(topic_endpoint(kind, name, qos, ignore_local=ignore_local), deliver)

    def service(self, name: str, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        return self.node.service(service_endpoint(EndpointKind.SERVICE, name), deliver)

    def client(self, name: str) -> ClientPort:
        """Declare a service client."""
        return self.node.client(service_endpoint(EndpointKind.CLIENT, name))


class Answers:
    """Collects what becomes of requests."""

    def __init__(self) -> None:
        self.replies: Collector[Sample] = Collector()
        self.reasons: list[str] = []
        self._ends: Collector[int] = Collector()

    def on_end(self, reason: str) -> None:
        """Note an end, why, and how many replies had come by then."""
        self.reasons.append(reason)
        self._ends(len(self.replies.items))

    def ask(self, client: ClientPort, payload: bytes = b'request') -> int:
        """Send one request; return its sequence number."""
        return client.request(payload, self.replies, self.on_end)

    def expect(self, replies: int, ends: int = 1) -> list[Sample]:
        """Wait for the ends of `ends` requests, then insist on the number of replies and return them."""
        self._ends.expect(ends, PATIENCE)
        assert len(self._ends.items) == ends
        assert len(self.replies.items) == replies, self.replies.items
        return self.replies.items

    @property
    def replies_before_each_end(self) -> list[int]:
        """How many replies had come when each request ended."""
        return self._ends.items
