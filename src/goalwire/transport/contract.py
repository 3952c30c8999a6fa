"""The contract of a transport: it moves bytes between endpoints and shows which others are there.

A transport knows nothing of message classes, users' callbacks or executors. It delivers on a thread of its
own or, inside one session, on the publisher's or caller's thread. So a `deliver` function must be short: it
appends to a queue, wakes a sleeping thread, and does nothing else. Callers of these methods never hold a lock
that a `deliver` function takes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

from goalwire.concurrency.wire_poller import WirePoller
from goalwire.records import record
from goalwire.rules.qos import DEFAULT, QoS

if TYPE_CHECKING:
    from goalwire.rules.names.robots import RobotView
    from goalwire.rules.qos_events import EventStatus, EventType
    from goalwire.security.refusal_counts import RefusalCounts

Payload: TypeAlias = bytes | bytearray | memoryview


class EndpointKind(Enum):
    """The kinds of endpoints, and NODE for a node itself."""

    # Members are keys in hot paths, and the __hash__ of Enum is a slow Python function. This one will do as
    # well, because each member exists only once.
    __hash__ = object.__hash__

    NODE = 'node'
    PUBLISHER = 'publisher'
    SUBSCRIPTION = 'subscription'
    SERVICE = 'service'
    CLIENT = 'client'


@record
class NodeName:
    """The name of a node: `name` without slashes, `namespace` absolute ('/' or '/a/b')."""

    name: str
    namespace: str = '/'
    enclave: str = '/'

    @property
    def qualified(self) -> str:
        """The node's fully-qualified name, '/a/b/name'."""
        return f'{self.namespace.rstrip("/")}/{self.name}'

    @property
    def logger(self) -> str:
        """The name of the node's logger, 'a.b.name' for the node /a/b/name."""
        return self.qualified.strip('/').replace('/', '.')


@record
class Endpoint:
    """An endpoint, as an entity declares it.

    `name` is fully qualified ('/chatter'). `type_name` is 'std_msgs/msg/String'; for services 'pkg/srv/Name',
    for an action's three services 'pkg/action/Name_SendGoal' and so on. `type_hash` is 'RIHS01_<64 hex>' of
    that type.
    """

    kind: EndpointKind
    name: str
    type_name: str
    type_hash: str
    qos: QoS
    has_buffers: bool = False
    """True if the type holds an unbounded sequence of primitives."""
    ignore_local: bool = False
    """True for a subscription that does not receive what its own session publishes."""
    takes_views: bool = False
    """True for a subscription that can read large payloads in the wire's own memory, without a copy."""
    waits_for_room: bool | None = None
    """True if a reliable publisher waits while the wire is full. None leaves that to the QoS: the publisher
    waits if its history is to reach all subscriptions. Publishers of feedback always wait; publishers of log
    lines and service events never do."""
    part_hashes: Callable[[], tuple[str, str]] | None = None
    """Returns the hashes of a service's request and response, for a wire that announces those (DDS)."""


class Sample(NamedTuple):
    """One message as it came from the wire; times in ns since the UNIX epoch, `gid` 16 bytes.

    `sequence` is 0 if the wire does not number a topic's messages (DDS).
    """

    payload: Payload
    sequence: int
    source_timestamp: int
    received_timestamp: int
    gid: bytes


new_sample: Callable[[tuple[Payload, int, int, int, bytes]], Sample] = partial(tuple.__new__, Sample)
"""Makes a Sample by tuple.__new__, without running Python code, since every message needs a Sample."""


class Request(ABC):
    """One request waiting for its reply at a service server."""

    __slots__ = ()
    sample: Sample
    """The request as it arrived; its `gid` is the client's."""

    @property
    def source_timestamp(self) -> int:
        """The time of sending in ns since the UNIX epoch. Programs read it from the request's header."""
        return self.sample.source_timestamp

    @property
    def received_timestamp(self) -> int:
        """The time of arrival in ns since the UNIX epoch."""
        return self.sample.received_timestamp

    @abstractmethod
    def reply(self, payload: bytes) -> None:
        """Send the answer, at most once. A client that has gone is not an error."""

    @abstractmethod
    def cancel(self, reason: str = '') -> None:
        """End the request without an answer; the client's `on_end` gets the reason."""


@record
class GraphEntity:
    """One node or endpoint as discovery shows it. `session` and `node_id` tell nodes of one name apart."""

    kind: EndpointKind
    session: str
    node_id: int
    node: NodeName
    name: str = ''
    type_name: str = ''
    """'pkg/msg/Name', as shown to users."""
    type_hash: str = ''
    qos: QoS = DEFAULT
    gid: bytes = b''


class GraphListener(ABC):
    """A listener of the graph's changes; called on transport threads, or from within `watch_graph`."""

    @abstractmethod
    def appeared(self, entity: GraphEntity) -> None:
        """A node or endpoint is there. It may be reported twice; then the second call changes nothing."""

    @abstractmethod
    def vanished(self, entity: GraphEntity) -> None:
        """A node or endpoint has gone. If it is unknown, this changes nothing."""

    def connected(self) -> None:  # noqa: B027 - most listeners have nothing to do
        """The answers of `ClientPort.reaches_server` or `Port.peer_count` may have changed."""


class Port(ABC):
    """A declared endpoint."""

    gid: bytes
    """16 bytes that name this endpoint on the wire."""

    @abstractmethod
    def close(self) -> None:
        """Undeclare the endpoint. Idempotent. Afterwards only messages already under way are delivered."""

    def watch_event(
        self,
        event: EventType,  # noqa: ARG002
        changed: Callable[[EventStatus], None],  # noqa: ARG002
    ) -> bool:
        """Call `changed` with an event's totals each time they change; False if the wire does not report it.

        An entity calls this at most once for each event, and the wire may start to count then. `changed` must
        be as short as a `deliver` function. If this returns False, the caller takes the event from the graph.
        """
        return False

    def peer_count(self) -> int | None:
        """Return how many endpoints are matched with this one; None if the wire does not count them.

        The count is at least as new as the last event about matches. If it is None, the caller counts in the
        graph. Otherwise, after the first call, each change of the count calls `GraphListener.connected`.
        """
        return None

    def catch_up(self) -> None:  # noqa: B027 - most wires deliver in the order in which things arrive
        """Deliver everything that has arrived by now.

        Only wires that do not deliver to all endpoints in the order of arrival have to override this method.
        """


class Loan(Protocol):
    """Memory of the wire that is lent to a program, to write one message into."""

    @property
    def view(self) -> memoryview:
        """The memory, writable. Raises ValueError if closing the session has taken the memory away."""

    def narrow(self, start: int, size: int) -> None:
        """Choose the message: `size` bytes from `start` on. The rest of the memory is not sent."""

    def end(self) -> None:
        """Give the memory back. A published message stays in the memory as long as a subscriber reads it."""


class PublisherPort(Port):
    """A declared publisher."""

    @property
    def dropped(self) -> int:
        """How many messages this publisher dropped after `publish` had returned, as far as the wire knows.

        A message that was dropped for two peers may count twice.
        """
        return 0

    @abstractmethod
    def publish(self, payload: bytes) -> None:
        """Hand one message to the wire. Raises ClosedError, ForkedError or TransportError."""

    can_lend = False
    """True if `borrow` may ever return memory. `publish` then takes Parts, too, and copies them there."""

    def borrow(self, size: int) -> Loan | None:  # noqa: ARG002
        """Return memory that subscribers can read in place; None, as here, if the wire has none."""
        return None

    def publish_loan(self, loan: Loan) -> None:
        """Publish the message that was written into a loan of this port. Raises as `publish` does."""
        self.publish(bytes(loan.view))

    def assert_liveliness(self) -> None:
        """Show that the publisher is alive, if its QoS leaves that to the user."""

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:  # noqa: ARG002
        """Wait until all reliable subscriptions have received every message; False if the time runs out
        first.

        Returns True, as here, if the wire has flow control only and no acknowledgements.
        """
        return True


class ClientPort(Port):
    """A declared service client.

    A wire keeps a table of its requests, and the entity has a table of its calls (`RequestClient.pending`),
    since a call and its request end at different times. A call ends with its first reply, or at its deadline.
    Its request ends when every server that was asked has answered or gone. Until then the wire finds the
    request, with the servers that have not answered yet, by its number: a reply on DDS holds nothing else.
    One table for both would need a mark of which of the two has ended, and each reply would have to look at
    that mark.
    """

    @abstractmethod
    def request(
        self,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Send one request and return its sequence number (1, 2, …).

        `on_reply` gets each reply (one per server); `on_end` fires once when no more can come: every
        server has answered, none was there, or the last one died. It gets the reason that a server gave for
        not answering, or ''. Both may fire before this returns. `timeout_ns` is how long the caller waits at
        most, None if it has no limit: after that time the wire may forget the request.
        """

    @abstractmethod
    def cancel(self, sequence: int) -> None:
        """Forget a request: nobody waits for its reply, and neither `on_reply` nor `on_end` is called.

        A callback that is running at this moment goes on. A request that has ended, or never was, is ignored.
        """

    def reaches_server(self) -> bool:
        """Return whether a server that the graph shows can be called now, and its reply can arrive.

        True, as here, if a server in the graph can always be called. Otherwise `GraphListener.connected` is
        called when the answer may have changed.
        """
        return True


class NodePort(Port):
    """A declared node, through which its endpoints are declared."""

    @abstractmethod
    def publisher(self, endpoint: Endpoint) -> PublisherPort:
        """Declare a publisher."""

    @abstractmethod
    def subscription(self, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Port:
        """Declare a subscription; transient_local history arrives through `deliver` too."""

    @abstractmethod
    def service(self, endpoint: Endpoint, deliver: Callable[[Request], None]) -> Port:
        """Declare a service server. It answers each request once, at any time, on any thread."""

    @abstractmethod
    def client(self, endpoint: Endpoint) -> ClientPort:
        """Declare a service client."""


class Session(ABC):
    """One context's connection to one domain."""

    id: str
    """The `session` that the graph shows for this session's own nodes and endpoints."""
    enforces_qos = False
    """True if endpoints with incompatible QoS exchange nothing (DDS). Otherwise QoS prevents nothing."""
    compares_definitions = True
    """True if different definitions of one type keep endpoints apart; DDS compares only names."""
    discovers_at_once = True
    """True if `watch_graph` reports the whole graph before it returns; otherwise the graph grows later."""
    knows_its_peers = False
    """True if the session meets only the peers that `has_heard_all` counts."""
    refusals: RefusalCounts | None = None
    """Counts of the acts that this session's policy has refused; None if it has no policy."""
    wire_poller: WirePoller | None = None
    """The poller with which idle threads wait on this wire; None if the wire's own threads do that."""

    @abstractmethod
    def node(self, name: NodeName) -> NodePort:
        """Declare a node."""

    @abstractmethod
    def watch_graph(self, listener: GraphListener) -> None:
        """Report everything known to `listener` before this returns, and every change from then on.

        The session's own nodes and endpoints are part of the graph.
        """

    def has_heard_all(self) -> bool:
        """Return whether all known peers have announced everything; True if the wire does not say."""
        return True

    @abstractmethod
    def silence(self) -> None:
        """Refuse to send from now on: publishers and clients raise ClosedError. Servers go on answering.

        Any thread may call this, also in a signal handler: it takes no lock, and waits for nothing.
        """

    @abstractmethod
    def close(self) -> None:
        """Undeclare everything, send the queued messages, disconnect.

        Idempotent; never called from `deliver`.
        """


@record
class SessionOptions:
    """A context's requirements for its session."""

    domain_id: int = 0
    enclave: str = '/'
    """The enclave of all nodes, for a wire that has one for each session (DDS)."""
    view: RobotView | None = None
    """The robots that the session looks at; None: everything. A wire may show more than that."""


@record
class Transport:
    """A kind of wire."""

    identifier: str
    """The transport's name in RMW_IMPLEMENTATION: 'rmw_zenoh_cpp', 'goalwire_memory'."""
    open: Callable[[SessionOptions], Session]
    """Opens a session. Raises TransportError with a sentence that says what to do."""
