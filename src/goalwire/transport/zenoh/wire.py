"""The interface of a Zenoh session that the ROS layer uses: goalwire's own, or eclipse-zenoh's.

Callbacks run on the thread that reads, or on the caller's within one session, with no lock held. They get the
same on both: a key, a payload, an attachment, and where it came from.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Never, Protocol, TypeAlias, runtime_checkable

from goalwire.concurrency.wire_poller import WirePoller
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import Payload, ReplyError
from goalwire.zenoh.protocol.primitives import SourceInfo, Timestamp
from goalwire.zenoh.protocol.shared_memory import Loan

HISTORY_S = 10.0
"""How long what a publisher sends waits for what it keeps. Its answers are taken as long as they come."""


class Message(Protocol):
    """A message or a reply."""

    @property
    def key(self) -> str:
        """The key of the message or query."""

    @property
    def payload(self) -> Payload | None:
        """None: the key was deleted."""

    @property
    def attachment(self) -> bytes | None:
        """The attachment: sequence number, time and gid."""

    @property
    def timestamp(self) -> Timestamp | None:
        """When it was put, and by which session's clock. Raises RemoteError."""

    @property
    def source_info(self) -> SourceInfo | None:
        """The publisher and number of the message, if the publisher numbers. Raises RemoteError."""


Left: TypeAlias = tuple[object, Callable[[], None]]
"""A link that had no room for a message, and a function that sends it there and may wait."""
OnMessage: TypeAlias = Callable[[Message], None]
OnAnswer: TypeAlias = Callable[[Message | ReplyError], None]
OnToken: TypeAlias = Callable[[str, bool], None]
"""Gets a token, and whether it is there now."""


class Declared(Protocol):
    """A declaration."""

    def undeclare(self) -> object:
        """Take it off the wire. Idempotent."""


def undeclare(declared: Declared) -> None:
    """Take something off the wire, or leave that to the thread that is using it.

    Zenoh's Python objects refuse while another thread is inside one of their methods, and undeclare
    themselves when the last reference goes: so the caller drops its own afterwards.
    """
    with suppress(RuntimeError):  # its text is "Already borrowed"
        declared.undeclare()


def refuse_use(*_: object, **__: object) -> Never:
    """Stand in for a method of something undeclared; its owner turns this into ClosedError."""
    raise RuntimeError('undeclared')


@runtime_checkable
class LoanPublisher(Protocol):
    """A declared publisher that can put what was written into shared memory."""

    @property
    def put_loan(self) -> Callable[[Loan, Callable[[], bytes]], bool]:
        """Called with a loan and what makes the attachment; False: nothing was put, as some need bytes."""

    def borrow(self, size: int) -> Loan | None:
        """Return a chunk of shared memory; None if there is no room, or nobody who could read it."""


class Subscriber(Declared, Protocol):
    """A declared subscriber."""

    @property
    def address(self) -> str:
        """Its session and its number there, 'session/number'."""


class Publisher(Declared, Protocol):
    """A declared publisher."""

    @property
    def put(self) -> Callable[..., None]:
        """Called with a payload and `attachment=`; puts one message."""

    @property
    def put_where_free(self) -> Callable[..., Sequence[Left]]:
        """Called with a payload, an attachment, the links behind whose messages it has to wait, and `waits=`.

        Puts one message on the other links, as far as they have room, and returns those that are left. With
        `waits`, their functions wait for room; otherwise they may drop the message. A session without a view
        of its links has one for all, which has never room for a large message.
        """


class Querier(ABC):
    """Asks all complete queryables of one key."""

    @abstractmethod
    def ask(
        self,
        payload: Payload,
        attachment: bytes,
        on_answer: OnAnswer,
        on_end: Callable[[], None],
        timeout_ns: int | None,
    ) -> object:
        """Send a query and return what `cancel` takes. `on_end` is called once, when no answer can come.

        `timeout_ns` is how long an answer is wanted at least; None: ten minutes, as under rmw_zenoh.
        """

    @abstractmethod
    def cancel(self, asked: object) -> None:
        """Forget a query. A query that has ended is ignored."""

    @abstractmethod
    def undeclare(self) -> object:
        """Stop asking; queries on their way go on."""


class Wire(ABC):
    """An open session."""

    id: str
    """The session's id, as keys and users show it."""
    wire_poller: WirePoller | None
    """The place where idle threads wait on the wire; None for a wire that has threads of its own for that."""
    errors: tuple[type[Exception], ...]
    """The exceptions that these methods raise when they fail or the session is closed."""
    discovers_at_once = False
    """True if opening waits until the router has told what it knows. eclipse-zenoh sometimes does not
    (1.10.2)."""

    @abstractmethod
    def explain(self, error: Exception) -> str:
        """Return the text of one of `errors`, for users."""

    @abstractmethod
    def declare_publisher(self, key: str, *, reliable: bool, waits: bool) -> Publisher:
        """Declare a publisher on a key.

        With `waits` it waits if the wire is full; otherwise messages are dropped.
        """

    @abstractmethod
    def declare_history_publisher(self, key: str, *, reliable: bool, waits: bool, depth: int) -> Publisher:
        """Declare a publisher that keeps its last messages for later subscribers, as Zenoh's advanced
        publishers do.

        It shows itself by a token `<key>/@adv/pub/<session>/<number>/_` and answers queries on that key. The
        number is 'uhlc' unless it is reliable and so numbers its messages.
        """

    @abstractmethod
    def declare_subscriber(
        self, key: str, on_message: OnMessage, *, takes_own: bool = True, takes_views: bool = False
    ) -> Subscriber:
        """Declare a callback for messages on matching keys; with `takes_own` also for this session's.

        With `takes_views` payloads may stay in shared memory, and are read-only views of it.
        """

    @abstractmethod
    def declare_queryable(self, key: str, on_query: Callable[[Query], None]) -> Declared:
        """Declare a complete queryable: the callback gets queries on the key, and each must be ended."""

    @abstractmethod
    def declare_querier(self, key: str) -> Querier:
        """Declare a querier of a key."""

    @abstractmethod
    def ask_all(
        self,
        key: str,
        parameters: str,
        on_answer: OnAnswer,
        on_end: Callable[[], None],
        *,
        publisher: str,
        asks_own: bool = True,
    ) -> None:
        """Ask every queryable that matches, complete or not, for replies on any key.

        `publisher` is the session that has the answer: if it has a link of its own, nobody else is asked.
        """

    @abstractmethod
    def declare_token(self, token: str) -> Declared:
        """Show a token to all watchers."""

    @abstractmethod
    def watch_tokens(self, key: str, on_token: OnToken, *, waits: bool) -> Declared:
        """Tell of present tokens, some maybe twice, and of those that come and go, in order.

        With `waits`, what others answer within a while is told before this returns.
        """

    @abstractmethod
    def wait_for_router(self, seconds: float) -> bool:
        """Return whether there is a link to a router, or one comes up within `seconds`.

        A peer that answers where a router was expected will do: it is linked, and works.
        """

    @abstractmethod
    def watch_routers(self, on_router: Callable[[str, str], None]) -> Declared:
        """Tell of each link to a router that there is or comes to be: its id, and the address dialled."""

    def call_later(self, seconds: float, function: Callable[[], None]) -> Callable[[], object]:  # noqa: ARG002
        """Call a function later on the thread that reads, and return what cancels that; or do nothing.

        Nothing is done by a session that has no such thread: its caller must look at the time itself.
        """
        return bool

    def refused(self) -> dict[str, int]:
        """Return how many messages of peers were ignored, by kind, as far as the session tells."""
        return {}

    @abstractmethod
    def close(self) -> None:
        """Send what waits, disconnect, and wait for callbacks under way.

        Raises one of `errors` if cut short.
        """
