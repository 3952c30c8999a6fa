"""Two ends of a wire for tests: sessions, a node in each, and what each sees of the graph."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import NamedTuple

from helpers.collector import Collector
from helpers.patience import PATIENCE
from helpers.wires import DDS

from goalwire.rules.qos import QoS
from goalwire.transport.contract import (
    ClientPort,
    Endpoint,
    EndpointKind,
    GraphEntity,
    GraphListener,
    NodeName,
    Payload,
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
_ENCAPSULATION = b'\0\1\0\0'


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


def numbers(transport: str, expected: list[int]) -> list[int]:
    """Return the sequence numbers that samples of a topic have on a wire: DDS does not tell them."""
    return [0] * len(expected) if transport == DDS else expected


def message(content: bytes) -> bytes:
    """Return a serialized message, as every transport carries it: an encapsulation and one uint8[]."""
    return b''.join((_ENCAPSULATION, len(content).to_bytes(4, 'little'), content))


def content(payload: Payload) -> bytes:
    """Return what `message` was given, whatever padding a wire has put behind it."""
    raw = bytes(payload)
    assert raw[:4] == _ENCAPSULATION
    size = int.from_bytes(raw[4:8], 'little')
    assert len(raw) - 8 - size in range(4)
    return raw[8 : 8 + size]


class Wrapping(NamedTuple):
    """How contents become payloads, and payloads contents."""

    pack: Callable[[bytes], bytes]
    unpack: Callable[[Payload], bytes]


IN_CDR = Wrapping(message, content)
BARE = Wrapping(bytes, bytes)
"""Contents travel as they are: not every wire takes them."""


class ContentPublisher(PublisherPort):
    """A publisher of messages that are one uint8[]."""

    def __init__(self, port: PublisherPort, wrapping: Wrapping) -> None:
        self.port = port
        self._pack = wrapping.pack
        self.gid = port.gid

    def publish(self, payload: bytes) -> None:
        """Publish one message."""
        self.port.publish(self._pack(payload))

    def close(self) -> None:
        """Undeclare."""
        self.port.close()


class ContentClient(ClientPort):
    """A client whose requests and replies are one uint8[]."""

    def __init__(self, port: ClientPort, wrapping: Wrapping) -> None:
        self.port = port
        self._wrapping = wrapping
        self.gid = port.gid

    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request."""

        def unwrap(reply: Sample) -> None:
            on_reply(reply._replace(payload=self._wrapping.unpack(reply.payload)))

        return self.port.request(self._wrapping.pack(payload), unwrap, on_end, timeout_ns)

    def cancel(self, sequence: int) -> None:
        """Wait for a reply no longer."""
        self.port.cancel(sequence)

    def reaches_server(self) -> bool:
        """Whether a request would be answered."""
        return self.port.reaches_server()

    def close(self) -> None:
        """Undeclare."""
        self.port.close()


class ContentRequest(Request):
    """A request that is one uint8[], and so is its reply."""

    def __init__(self, request: Request, wrapping: Wrapping) -> None:
        self._request = request
        self._pack = wrapping.pack
        self.sample = request.sample._replace(payload=wrapping.unpack(request.sample.payload))

    def reply(self, payload: bytes) -> None:
        self._request.reply(self._pack(payload))

    def cancel(self, reason: str = '') -> None:
        self._request.cancel(reason)


class SeenGraph(GraphListener):
    """The graph as a session has been told of it, to be waited on."""

    def __init__(self) -> None:
        self._entities: dict[tuple[str, int, bytes, EndpointKind], GraphEntity] = {}
        self._connections = 0
        self._changed = threading.Condition()

    def appeared(self, entity: GraphEntity) -> None:
        with self._changed:
            self._entities[entity.session, entity.node_id, entity.gid, entity.kind] = entity
            self._changed.notify_all()

    def vanished(self, entity: GraphEntity) -> None:
        with self._changed:
            self._entities.pop((entity.session, entity.node_id, entity.gid, entity.kind), None)
            self._changed.notify_all()

    def connected(self) -> None:
        with self._changed:
            self._connections += 1
            self._changed.notify_all()

    def wait_for(self, predicate: Callable[[], bool]) -> None:
        """Wait for something that changes with what is connected."""
        with self._changed:
            assert self._changed.wait_for(predicate, PATIENCE)

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

    def __init__(self, session: Session, node_name: str, wrapping: Wrapping = IN_CDR) -> None:
        self.session = session
        self._wrapping = wrapping
        self.graph = SeenGraph()
        session.watch_graph(self.graph)
        self.node = session.node(NodeName(node_name))

    def publisher(self, name: str, qos: QoS | None = None, *, type_hash: str = HASH) -> ContentPublisher:
        """Declare a publisher."""
        endpoint = topic_endpoint(EndpointKind.PUBLISHER, name, qos, type_hash=type_hash)
        return ContentPublisher(self.node.publisher(endpoint), self._wrapping)

    def subscription(
        self,
        name: str,
        deliver: Callable[[Sample], None],
        qos: QoS | None = None,
        *,
        ignore_local: bool = False,
    ) -> Port:
        """Declare a subscription."""

        def unwrap(sample: Sample) -> None:
            deliver(sample._replace(payload=self._wrapping.unpack(sample.payload)))

        kind = EndpointKind.SUBSCRIPTION
        return self.node.subscription(topic_endpoint(kind, name, qos, ignore_local=ignore_local), unwrap)

    def service(self, name: str, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server."""
        endpoint = service_endpoint(EndpointKind.SERVICE, name)
        return self.node.service(endpoint, lambda request: deliver(ContentRequest(request, self._wrapping)))

    def client(self, name: str) -> ContentClient:
        """Declare a service client."""
        client = self.node.client(service_endpoint(EndpointKind.CLIENT, name))
        return ContentClient(client, self._wrapping)

    def expect_server(self, client: ContentClient, name: str, number: int = 1) -> None:
        """Wait until the graph shows that many servers, and the client can call."""
        self.graph.expect(EndpointKind.SERVICE, name, number)
        self.graph.wait_for(client.reaches_server)


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

    def ask(self, client: ContentClient, payload: bytes = b'request') -> int:
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
