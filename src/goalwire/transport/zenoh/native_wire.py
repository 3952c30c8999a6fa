"""The ROS layer's wire, on a session of goalwire's own."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Container, Sequence
from functools import partial
from itertools import count
from threading import RLock
from typing import TYPE_CHECKING

from goalwire.errors import ClosedError
from goalwire.records import replace
from goalwire.transport.zenoh import wire
from goalwire.transport.zenoh.ros_keys import GRAPH_SPACE, RobotKeys
from goalwire.zenoh.io.native_session import NativeSession
from goalwire.zenoh.io.settings import Settings
from goalwire.zenoh.protocol.bodies import Payload, Sample
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.link_messages import Role
from goalwire.zenoh.protocol.network import Target
from goalwire.zenoh.protocol.primitives import (
    SourceInfo,
    ZenohProtocolError,
    encode_source,
    show_id,
)
from goalwire.zenoh.protocol.publication import Publication
from goalwire.zenoh.protocol.querier import Querier
from goalwire.zenoh.protocol.queries import ANY_KEY
from goalwire.zenoh.protocol.session_protocol import SessionProtocol
from goalwire.zenoh.protocol.shared_memory import Loan

if TYPE_CHECKING:
    from goalwire.transport.zenoh.policy_enforcement import PolicyEnforcement

TOKEN_KEYS = (f'{GRAPH_SPACE}/**', '**/@adv/**')
"""The key expressions of tokens: of nodes and endpoints, and of publishers and subscribers with history.

A router with access control gives nothing to a session that asks for everything at once, without a key.
"""
UNNUMBERED = 'uhlc'
"""The chunk in place of the entity number, for a publisher that does not number its messages."""

_MOST_DIGITS = 20  # a number of 64 bits has at most 20 digits


class _Declared:
    """A declaration, which the protocol knows by a number."""

    __slots__ = ('_number', '_protocol', 'address')

    def __init__(self, protocol: SessionProtocol, number: int) -> None:
        self._protocol = protocol
        self._number = number
        self.address = f'{protocol.id}/{number}'

    def undeclare(self) -> None:
        """Undeclare it."""
        self._protocol.undeclare(self._number)


class _Publisher:
    """A publisher without history."""

    __slots__ = ('_publication', 'borrow', 'put', 'put_loan', 'put_where_free')

    def __init__(self, publication: Publication, borrow: Callable[[int], Loan | None]) -> None:
        self._publication = publication
        self.borrow = borrow
        self.put_loan = publication.put_loan
        self.put: Callable[..., None] = publication.put
        self.put_where_free: Callable[..., Sequence[wire.Left]] = publication.put_where_free

    def undeclare(self) -> None:
        """Undeclare the number that stands for the publisher's key."""
        self._publication.close()


def _no_loan(_size: int) -> Loan | None:
    return None


class HistoryPublisher:
    """A publisher that keeps its last messages. If it `numbers` them, it counts from 0."""

    def __init__(
        self, session: NativeSession, key: str, publication: Publication, depth: int, *, numbers: bool
    ) -> None:
        protocol = session.protocol
        entity = publication.number
        self._key = key
        self._publication = publication
        self._protocol = protocol
        self._source = partial(SourceInfo, protocol.zid, entity) if numbers else None
        self._next_number = count().__next__
        self._kept: deque[tuple[int, Sample]] = deque(maxlen=depth)
        self._lock = RLock()
        address = f'{key}/@adv/pub/{protocol.id}/{entity if numbers else UNNUMBERED}/_'
        self._declared = [
            protocol.declare_queryable(address, self._on_query, complete=False),
            protocol.declare_token(address),
        ]

    def put(self, payload: Payload, attachment: bytes | None = None) -> None:
        """Put a message and keep it. The caller makes sure that calls do not overlap."""
        stamp, source = self._keep(payload, attachment)
        self._publication.put(payload, attachment, stamp, source)

    def put_where_free(
        self, payload: Payload, attachment: bytes, full: Container[object], *, waits: bool
    ) -> Sequence[wire.Left]:
        """Keep a message, and put it on the links that have room; return the others."""
        stamp, source = self._keep(payload, attachment)
        return self._publication.put_where_free(
            payload, attachment, full, waits=waits, stamp=stamp, source=source
        )

    def _keep(self, payload: Payload, attachment: bytes | None) -> tuple[bytes, SourceInfo | None]:
        """Stamp a message, number it, and keep it."""
        stamp = self._protocol.stamp()
        number = self._next_number()
        source = None if self._source is None else self._source(number)
        encoded = None if source is None else encode_source(source)
        with self._lock:
            self._kept.append((number, Sample(self._key, payload, attachment, stamp, encoded)))
        return stamp, source

    def _on_query(self, query: Query) -> None:
        """Answer with kept messages: the last ones up to `_max`, or those in the range of numbers `_sn`."""
        with self._lock:
            kept = list(self._kept)
        wanted = dict(part.partition('=')[::2] for part in query.parameters.split(';'))
        if '_sn' in wanted:
            first, _, last = wanted['_sn'].partition('..')
            low, high = _number(first, 0), _number(last, 2**32)
            kept = [each for each in kept if low <= each[0] <= high]
        if '_max' in wanted:
            most = _number(wanted['_max'], len(kept))
            kept = kept[-most:] if most else []
        for _, sample in kept:
            assert sample.payload is not None
            query.reply(sample.key, sample.payload, sample.attachment, sample.stamp, sample.source)
        query.end()

    def undeclare(self) -> None:
        """Undeclare, and forget the kept messages."""
        for number in self._declared:
            self._protocol.undeclare(number)
        self._publication.close()


def _number(text: str, otherwise: int) -> int:
    """Read a number in a query. Digits beyond 20 are cut off, since int() refuses thousands of them."""
    return int(text[:_MOST_DIGITS]) if text.isascii() and text.isdigit() else otherwise


class _Querier(wire.Querier):
    """Asks all complete queryables of a key."""

    def __init__(self, protocol: SessionProtocol, key: str, untimed_s: float) -> None:
        self._untimed_s = untimed_s
        self._querier = Querier(protocol, key, target=Target.ALL_COMPLETE)
        self._ask = self._querier.ask
        self._cancel = protocol.queries.cancel
        self._is_open = True

    def ask(
        self,
        payload: Payload,
        attachment: bytes,
        on_answer: wire.OnAnswer,
        on_end: Callable[[], None],
        timeout_ns: int | None,
    ) -> object:
        """Send a query and return its number."""
        if not self._is_open:
            raise ClosedError('undeclared')
        seconds = self._untimed_s if timeout_ns is None else timeout_ns // 1_000_000_000 + 1.0
        return self._ask(payload, attachment, on_answer, on_end, seconds)

    def cancel(self, asked: object) -> None:
        """Forget a query."""
        assert isinstance(asked, int)
        self._cancel(asked)

    def undeclare(self) -> None:
        """Stop asking."""
        self._is_open = False
        self._querier.close()


class NativeWire(wire.Wire):
    """A session of goalwire's own."""

    errors = (ZenohProtocolError, ClosedError, RuntimeError)
    discovers_at_once = True

    def __init__(
        self, settings: Settings, security: PolicyEnforcement | None = None, scope: RobotKeys | None = None
    ) -> None:
        """Open the session. Raises TransportError.

        With `security` all links are checked against a policy; with `scope` routers are asked for the
        entities of some robots only.
        """
        self._security = security
        if security is not None:
            settings = replace(settings, identify=security.identify)
        if scope is None:
            settings = replace(settings, token_keys=TOKEN_KEYS)
        else:
            settings = replace(settings, token_keys=scope.tokens, entity_keys=scope.entities)
        self.session = NativeSession(settings)
        if security is not None:
            security.watch(self.session)
            self.refusals = security.refusals
        self.id = self.session.id
        self.wire_poller = self.session.wire_poller
        self._protocol = self.session.protocol
        self._untimed_s = settings.untimed_s

    def explain(self, error: Exception) -> str:
        return str(error)

    def declare_publisher(self, key: str, *, reliable: bool, waits: bool) -> wire.Publisher:
        # Best-effort messages use the reliable channel, too, as in rmw_zenoh: TCP loses nothing.
        publication = Publication(self._protocol, key, droppable=not (reliable and waits))
        memory = self._protocol.memory
        return _Publisher(publication, _no_loan if memory is None else memory.borrow)

    def declare_history_publisher(
        self, key: str, *, reliable: bool, waits: bool, depth: int
    ) -> wire.Publisher:
        publication = Publication(self._protocol, key, droppable=not (reliable and waits))
        return HistoryPublisher(self.session, key, publication, depth, numbers=reliable)

    def declare_subscriber(
        self, key: str, on_message: wire.OnMessage, *, takes_own: bool = True, takes_views: bool = False
    ) -> wire.Subscriber:
        number = self._protocol.declare_subscriber(
            key, on_message, takes_own=takes_own, takes_views=takes_views
        )
        return _Declared(self._protocol, number)

    def declare_queryable(self, key: str, on_query: Callable[[Query], None]) -> wire.Declared:
        number = self._protocol.declare_queryable(key, on_query, complete=True)
        return _Declared(self._protocol, number)

    def declare_querier(self, key: str) -> wire.Querier:
        return _Querier(self._protocol, key, self._untimed_s)

    def ask_all(
        self,
        key: str,
        parameters: str,
        on_answer: wire.OnAnswer,
        on_end: Callable[[], None],
        *,
        publisher: str,
        asks_own: bool = True,
    ) -> None:
        querier = Querier(
            self._protocol,
            key,
            target=Target.ALL,
            parameters=f'{parameters};{ANY_KEY}',
            asks_own=asks_own,
            session_asked=publisher,
        )
        try:
            querier.ask(None, None, on_answer, on_end, self._untimed_s)
        finally:
            querier.close()

    def declare_token(self, token: str) -> wire.Declared:
        return _Declared(self._protocol, self._protocol.declare_token(token))

    def watch_tokens(
        self,
        key: str,
        on_token: wire.OnToken,
        *,
        waits: bool,  # noqa: ARG002
        own_only: bool = False,
    ) -> wire.Declared:
        def tell(change: Sample) -> None:
            on_token(change.key, change.payload is not None)

        number = self._protocol.watch_tokens(key, tell, history=True, own_only=own_only)
        return _Declared(self._protocol, number)

    def wait_for_router(self, seconds: float) -> bool:
        return self.session.wait_until(self._has_router, seconds)

    def _has_router(self) -> bool:
        is_router = any(link.role is Role.ROUTER for link in self._protocol.links)
        return is_router or self.session.is_connected()

    def watch_routers(self, on_router: Callable[[str, str], None]) -> wire.Declared:
        return self.session.watch_links(
            lambda link, address: on_router(show_id(link.zid), address) if link.role is Role.ROUTER else None
        )

    def call_later(self, seconds: float, function: Callable[[], None]) -> Callable[[], object]:
        return self.session.call_later(seconds, function).cancel

    def refused(self) -> dict[str, int]:
        refused = {} if self._security is None else self._security.refused.counts()
        return {**self.session.rejects.counts(), **refused}

    def close(self) -> None:
        self.session.close()
        if self._security is not None:
            self._security.close()
