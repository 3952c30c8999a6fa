"""The interface of a Zenoh session that the ROS layer uses: goalwire's own, or eclipse-zenoh's.

Callbacks run on the thread that reads, or on the caller's thread within one session, with no lock held. They
get the same values from both kinds of session: key, payload, attachment, and the message's origin.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Never, Protocol, TypeAlias, runtime_checkable

from goalwire.concurrency.wire_poller import WirePoller
from goalwire.zenoh.protocol.bodies import Payload
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import ReplyError
from goalwire.zenoh.protocol.primitives import SourceInfo, Timestamp
from goalwire.zenoh.protocol.shared_memory import Loan

if TYPE_CHECKING:
    from goalwire.security.refusal_counts import RefusalCounts

HISTORY_S = 10.0
"""How long live messages wait for a publisher's history. Later answers are taken nevertheless."""


class Message(Protocol):
    """A message or a reply."""

    @property
    def key(self) -> str:
        """The key of the message or query."""

    @property
    def payload(self) -> Payload | None:
        """The payload; None if the key was deleted."""

    @property
    def attachment(self) -> bytes | None:
        """The attachment: sequence number, time and gid."""

    @property
    def timestamp(self) -> Timestamp | None:
        """The time at which the message was put, and the session whose clock that is. Raises RemoteError."""

    @property
    def source_info(self) -> SourceInfo | None:
        """The message's publisher and number, if the publisher numbers its messages. Raises RemoteError."""


Left: TypeAlias = tuple[object, Callable[[], None]]
"""A link that had no room for a message, and a function that sends it there and may wait."""
OnMessage: TypeAlias = Callable[[Message], None]
OnAnswer: TypeAlias = Callable[[Message | ReplyError], None]
OnToken: TypeAlias = Callable[[str, bool], None]
"""Is called with a token, and True if it has appeared or False if it has vanished."""


class Declared(Protocol):
    """A declaration."""

    def undeclare(self) -> object:
        """Undeclare it. Idempotent."""


def undeclare(declared: Declared) -> None:
    """Undeclare something, or leave that to the thread that is using it.

    Zenoh's Python objects raise while another thread is inside one of their methods, and undeclare themselves
    when the last reference is deleted. So the caller drops its own reference afterwards.
    """
    with suppress(RuntimeError):  # "Already borrowed": another thread is using the object
        declared.undeclare()


def refuse_use(*_: object, **__: object) -> Never:
    """Stand in for the methods of an undeclared object. The owner turns the error into ClosedError."""
    raise RuntimeError('undeclared')


@runtime_checkable
class LoanPublisher(Protocol):
    """A declared publisher that can put messages which were written into shared memory."""

    @property
    def put_loan(self) -> Callable[[Loan, Callable[[], bytes]], bool]:
        """Takes a loan and a function for the attachment; False, with nothing put, if a link needs bytes."""

    def borrow(self, size: int) -> Loan | None:
        """Return a chunk of shared memory; None if there is no room, or if no subscriber could read it."""


class Subscriber(Declared, Protocol):
    """A declared subscriber."""

    @property
    def address(self) -> str:
        """The subscriber's session and its number there, 'session/number'."""


class Publisher(Declared, Protocol):
    """A declared publisher."""

    @property
    def put(self) -> Callable[..., None]:
        """Puts one message; takes a payload and `attachment=`."""

    @property
    def put_where_free(self) -> Callable[..., Sequence[Left]]:
        """Puts one message on the links that have room, and returns the others, each with a function.

        Takes a payload, an attachment, the links on which earlier messages wait, and `waits=`. The function
        of a link sends the message there. With `waits` the function waits for room; otherwise it may drop the
        message. A session that does not show its links returns one entry for all, whatever room they have.
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
        """Send a query; return an object for `cancel`. `on_end` is called once, after the last answer.

        The query lasts at least `timeout_ns`, or ten minutes if that is None, as in rmw_zenoh.
        """

    @abstractmethod
    def cancel(self, asked: object) -> None:
        """Forget a query. A query that has ended is ignored."""

    @abstractmethod
    def undeclare(self) -> object:
        """Undeclare the querier. Queries that were sent before go on."""


class Wire(ABC):
    """An open session."""

    id: str
    """The session's id, as keys and users show it."""
    wire_poller: WirePoller | None
    """The poller with which idle threads wait on the wire; None if the wire's own threads do that."""
    errors: tuple[type[Exception], ...]
    """The exceptions that these methods raise when they fail or the session is closed."""
    refusals: RefusalCounts | None = None
    """Counts of the acts that the session's policy has refused; None if it has no policy."""
    discovers_at_once = False
    """True if opening waits until the router has reported all it knows. eclipse-zenoh sometimes does not wait
    (1.10.2)."""

    @abstractmethod
    def explain(self, error: Exception) -> str:
        """Return the text of one of `errors`, for users."""

    @abstractmethod
    def declare_publisher(self, key: str, *, reliable: bool, waits: bool) -> Publisher:
        """Declare a publisher on a key.

        With `waits` it waits for room on a full wire; otherwise it drops messages.
        """

    @abstractmethod
    def declare_history_publisher(self, key: str, *, reliable: bool, waits: bool, depth: int) -> Publisher:
        """Declare a publisher that keeps its last messages for later subscribers.

        As Zenoh's advanced publishers, it declares a token `<key>/@adv/pub/<session>/<number>/_` and answers
        queries on that key. A reliable publisher numbers its messages; for others <number> is 'uhlc'.
        """

    @abstractmethod
    def declare_subscriber(
        self, key: str, on_message: OnMessage, *, takes_own: bool = True, takes_views: bool = False
    ) -> Subscriber:
        """Declare a callback for messages on matching keys; with `takes_own` also for the session's own.

        With `takes_views` payloads may stay in shared memory, and are read-only views of it.
        """

    @abstractmethod
    def declare_queryable(self, key: str, on_query: Callable[[Query], None]) -> Declared:
        """Declare a complete queryable. The callback gets queries on the key, and must end each of them."""

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

        `publisher` is the session that has the answer. If there is a link to it, only that session is asked.
        """

    @abstractmethod
    def declare_token(self, token: str) -> Declared:
        """Show a token to all watchers."""

    @abstractmethod
    def watch_tokens(self, key: str, on_token: OnToken, *, waits: bool, own_only: bool = False) -> Declared:
        """Report existing tokens, perhaps twice, and then all that come and go, in order.

        With `waits`, existing tokens are reported before this returns, if others answer soon enough. With
        `own_only` the key matches this session's tokens alone, so nobody else needs to be asked.
        """

    @abstractmethod
    def wait_for_router(self, seconds: float) -> bool:
        """Return whether there is a link to a router, or one comes up within `seconds`.

        A peer that answers at a router's address counts, too, since the link to it works.
        """

    @abstractmethod
    def watch_routers(self, on_router: Callable[[str, str], None]) -> Declared:
        """Report each link to a router, now and later: the router's id, and the address that was dialled."""

    def call_later(self, seconds: float, function: Callable[[], None]) -> Callable[[], object]:  # noqa: ARG002
        """Call a function later on the thread that reads; return a function that cancels the call.

        A session without such a thread does nothing, as here: its caller must check the time itself.
        """
        return bool

    def refused(self) -> dict[str, int]:
        """Return how many messages of peers were ignored, by kind; empty if the session does not count."""
        return {}

    @abstractmethod
    def close(self) -> None:
        """Send the waiting messages, disconnect, and wait for running callbacks.

        Raises one of `errors` if cut short.
        """
