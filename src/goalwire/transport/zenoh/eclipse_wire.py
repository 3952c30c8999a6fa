"""The ROS layer's wire on a session of eclipse-zenoh.

Zenoh's threads call back through `Callback(…, indirect=False)`. Each callback first keeps its thread's state
(threads.py). Open sessions are counted: a thread that calls into an interpreter that is ending aborts the
process.

Zenoh keeps about a kilobyte of each query until the query's timeout, even if it was answered at once
(measured with 1.10.2), and a querier has one timeout for all its queries. So requests with a timeout go
through separate queriers, one for each power of two of seconds, declared at the first use. `session.get`
takes any timeout, but costs 5 µs more.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Sequence
from contextlib import suppress
from functools import partial
from threading import Event
from typing import Any, NamedTuple

import zenoh
from zenoh import ext
from zenoh.handlers import Callback

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.errors import TransportError
from goalwire.rules.time import S_TO_NS
from goalwire.transport.zenoh import eclipse_library, wire
from goalwire.transport.zenoh.settings.environment import advise_unreached
from goalwire.transport.zenoh.settings.values import Configuration
from goalwire.transport.zenoh.threads import keep_thread_state
from goalwire.transport.zenoh.wire import Declared, refuse_use, undeclare
from goalwire.zenoh.protocol.bodies import Payload
from goalwire.zenoh.protocol.incoming_queries import Query
from goalwire.zenoh.protocol.network import ReplyError
from goalwire.zenoh.protocol.primitives import SourceInfo, Timestamp, read_id
from goalwire.zenoh.protocol.queries import Answer

UNTIMED_S: float | None = None
"""The timeout of requests that set none. The value None means that of the configuration: ten minutes, as in
rmw_zenoh. A shorter timeout would end slow calls: a request may be answered late, and must not be sent
twice."""

_MANNER: dict[str, Any] = {
    'target': zenoh.QueryTarget.ALL_COMPLETE,
    'consolidation': zenoh.ConsolidationMode.NONE,
    'congestion_control': zenoh.CongestionControl.BLOCK,
}


class Queriers:
    """The queriers of one key."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        """Declare the querier for requests without a timeout."""
        self._declare: Callable[..., zenoh.Querier] = partial(session.declare_querier, key, **_MANNER)
        lasting = self._declare(timeout=UNTIMED_S)
        self._declared = {0: lasting}
        """The queriers by their timeout in s; 0 stands for requests without one."""
        self.get: Callable[..., object] = lasting.get
        """Sends a request without a timeout."""

    def get_within(self, timeout_ns: int) -> Callable[..., object]:
        """Return a function that sends a request with a timeout of one to two `timeout_ns`, at least 1 s."""
        seconds = 1 << (timeout_ns // S_TO_NS).bit_length()
        querier = self._declared.get(seconds) or self._add(seconds)
        return querier.get

    def _add(self, seconds: int) -> zenoh.Querier:
        new = self._declare(timeout=float(seconds))
        kept = self._declared.setdefault(seconds, new)
        if kept is not new:
            undeclare(new)  # another thread has declared one first
        return kept

    def undeclare(self) -> None:
        """Undeclare the queriers. To send after that raises RuntimeError."""
        self.get = self._declare = refuse_use
        while self._declared:
            undeclare(self._declared.popitem()[1])


CLOSING_S = 1.0
"""How long closing waits for running callbacks, which only append to a queue."""
ANSWER_S = 2.0
"""How long a peer that does not answer can delay the first look at the graph, and so a program's start.
Its tokens are not lost: they arrive later through the subscription."""


class InFlight:
    """The callbacks that zenoh still holds: each may be running, or may run later."""

    def __init__(self) -> None:
        self._held: set[object] = set()
        self._nobody_left: Event | None = None
        self.enter: Callable[[object], None] = self._held.add
        """Notes that a callback of this owner was given to zenoh."""

    def leave(self, owner: object) -> None:
        """Note that zenoh has released the owner's callback. Runs on any thread."""
        self._held.discard(owner)
        if self._nobody_left is not None and not self._held:
            self._nobody_left.set()

    def wait(self, timeout: float) -> bool:
        """Wait until zenoh holds no callback; False if it still does after `timeout` seconds."""
        self._nobody_left = Event()
        return not self._held or self._nobody_left.wait(timeout)


class EclipseMessage(NamedTuple):
    """A message from zenoh. Payload and attachment are read at once, the rest when needed."""

    raw: zenoh.Sample
    payload: Payload | None
    attachment: bytes | None

    @property
    def key(self) -> str:
        """Return the key."""
        return str(self.raw.key_expr)

    @property
    def timestamp(self) -> Timestamp | None:
        """Return the timestamp with the id of its session's clock. Its time is not needed, and always 0."""
        stamp = self.raw.timestamp
        return None if stamp is None else Timestamp(0, read_id(str(stamp.get_id())))

    @property
    def source_info(self) -> SourceInfo | None:
        """Return the message's publisher and number; None if the publisher does not number its messages."""
        info = self.raw.source_info
        if info is None:
            return None
        return SourceInfo(read_id(str(info.source_id.zid)), info.source_id.eid, info.source_sn)


def _message(raw: zenoh.Sample) -> EclipseMessage:
    attachment = raw.attachment
    payload = raw.payload.to_bytes() if raw.kind == zenoh.SampleKind.PUT else None
    return EclipseMessage(raw, payload, None if attachment is None else attachment.to_bytes())


class EclipseQuery(Query):
    """A query that was received from zenoh."""

    __slots__ = ('_query',)

    def __init__(self, query: zenoh.Query) -> None:
        payload, attachment = query.payload, query.attachment
        super().__init__(
            '',
            '',
            None if payload is None else payload.to_bytes(),
            None if attachment is None else attachment.to_bytes(),
        )
        self._query = query

    def _send(self, answer: Answer) -> None:
        if isinstance(answer, ReplyError):
            self._query.reply_err(answer.payload)
        else:
            self._query.reply(answer.key, answer.payload, attachment=answer.attachment)

    def _finish(self) -> None:
        self._query.drop()  # type: ignore[no-untyped-call]


class _Asked:
    """A query that eclipse-zenoh sends."""

    __slots__ = ('_in_flight', '_on_answer', '_on_end', 'token')

    def __init__(self, in_flight: InFlight, on_answer: wire.OnAnswer, on_end: Callable[[], None]) -> None:
        self._in_flight = in_flight
        self._on_answer = on_answer
        self._on_end = on_end
        self.token = zenoh.CancellationToken()
        """Cancels the query at once; without such a token zenoh keeps the query until its timeout."""
        in_flight.enter(self)

    def on_reply(self, reply: zenoh.Reply) -> None:
        """Deliver a reply. Runs on zenoh's thread, or on the caller's within one session."""
        keep_thread_state()
        if reply.ok is not None:
            self._on_answer(_message(reply.ok))
        elif reply.err is not None:
            self._on_answer(ReplyError(reply.err.payload.to_bytes()))

    def on_drop(self) -> None:
        """End the query: zenoh has released it, so no reply can come any more."""
        keep_thread_state()
        try:
            self._on_end()
        finally:
            self._in_flight.leave(self)


class _Querier(wire.Querier):
    """Asks all complete queryables of a key."""

    def __init__(self, session: zenoh.Session, in_flight: InFlight, key: str) -> None:
        self._queriers = Queriers(session, key)
        self._in_flight = in_flight

    def ask(
        self,
        payload: Payload,
        attachment: bytes,
        on_answer: wire.OnAnswer,
        on_end: Callable[[], None],
        timeout_ns: int | None,
    ) -> object:
        queriers = self._queriers
        get = queriers.get if timeout_ns is None else queriers.get_within(timeout_ns)
        asked = _Asked(self._in_flight, on_answer, on_end)
        try:
            get(
                handler=Callback(asked.on_reply, drop=asked.on_drop, indirect=False),
                payload=payload,
                attachment=attachment,
                cancellation_token=asked.token,
            )
        except BaseException:
            self._in_flight.leave(asked)
            raise
        return asked.token

    def cancel(self, asked: object) -> None:
        assert isinstance(asked, zenoh.CancellationToken)
        asked.cancel()  # type: ignore[no-untyped-call]

    def undeclare(self) -> None:
        self._queriers.undeclare()


class _Held:
    """A declaration. If a thread is using it during `undeclare`, that thread undeclares it afterwards."""

    def __init__(self, declared: Declared) -> None:
        self._declared = declared

    def undeclare(self) -> None:
        undeclare(self._declared)


class _Subscriber(_Held):
    """A subscriber and its address, 'session/number'."""

    def __init__(self, subscriber: zenoh.Subscriber[None]) -> None:
        super().__init__(subscriber)
        source = subscriber.id
        self.address = f'{source.zid}/{source.eid}'


_ALL_LINKS = object()


class _Publisher(_Held):
    """A publisher."""

    def __init__(
        self, publisher: zenoh.Publisher | ext.AdvancedPublisher, put_waiting: Callable[..., None]
    ) -> None:
        """`put_waiting` puts with congestion control BLOCK, however the publisher was declared."""
        super().__init__(publisher)
        self.put: Callable[..., None] = publisher.put
        self._put_waiting = put_waiting

    def put_where_free(
        self,
        payload: Payload,
        attachment: bytes,
        full: Container[object],  # noqa: ARG002
        *,
        waits: bool,
    ) -> Sequence[wire.Left]:
        """Put nothing yet; return one entry for all links, since zenoh does not tell which have room."""
        put = self._put_waiting if waits else self.put
        return [(_ALL_LINKS, partial(put, payload, attachment=attachment))]


class _TokenWatch:
    """One watcher and the tokens on their way to it.

    A liveliness subscriber reports the existing tokens only at some later time. So they are queried, and the
    answer is awaited while changes queue up. A token that disappears meanwhile is first reported as present.
    """

    def __init__(self, in_flight: InFlight, on_token: wire.OnToken) -> None:
        self._in_flight = in_flight
        self._on_token = on_token
        self._changes: OrderedDispatcher[tuple[str, bool]] = OrderedDispatcher(
            lambda change: on_token(*change)
        )

    def start(self, session: zenoh.Session, key: str, *, waits: bool) -> zenoh.Subscriber[None]:
        """Report all existing tokens, then follow the changes."""
        liveliness = session.liveliness()
        self._in_flight.enter(self)
        follow = Callback(self._on_change, drop=self._on_drop, indirect=False)
        if not waits:
            return liveliness.declare_subscriber(key, follow, history=True)
        answered = Event()
        with self._changes.first_turn():
            subscriber = liveliness.declare_subscriber(key, follow, history=True)
            ask = Callback(self._on_answer, drop=answered.set, indirect=False)
            liveliness.get(key, ask, timeout=ANSWER_S)
            answered.wait(ANSWER_S)
        return subscriber

    def _on_answer(self, reply: zenoh.Reply) -> None:
        keep_thread_state()
        if reply.ok is not None:
            self._on_token(str(reply.ok.key_expr), True)  # before the changes

    def _on_change(self, sample: zenoh.Sample) -> None:
        keep_thread_state()
        self._changes.post((str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT))
        self._changes.drain()

    def _on_drop(self) -> None:
        self._in_flight.leave(self)


class EclipseWire(wire.Wire):
    """A session of eclipse-zenoh."""

    errors = (zenoh.ZError, RuntimeError)
    wire_poller = None

    def __init__(self, configuration: Configuration) -> None:
        """Open the session. Raises TransportError or ForkedError."""
        try:
            self._zenoh = eclipse_library.open_zenoh(configuration)
        except zenoh.ZError as error:
            raise TransportError(
                f'cannot open a Zenoh session (connecting to '
                f'{json.dumps(configuration.at("connect/endpoints"))}, listening on '
                f'{json.dumps(configuration.at("listen/endpoints"))}): {eclipse_library.reason(error)}; '
                f'{advise_unreached(str(configuration.at("mode")))}'
            ) from None
        self.id = str(self._zenoh.zid())
        self._in_flight = InFlight()

    def explain(self, error: Exception) -> str:
        return eclipse_library.reason(error)

    def declare_publisher(self, key: str, *, reliable: bool, waits: bool) -> wire.Publisher:
        publisher = self._zenoh.declare_publisher(
            key, congestion_control=_congestion(reliable, waits), reliability=_reliability(reliable)
        )
        return _Publisher(publisher, self._put_waiting(key))

    def declare_history_publisher(
        self, key: str, *, reliable: bool, waits: bool, depth: int
    ) -> wire.Publisher:
        """Declare a publisher with history. Unlike rmw_zenoh's, it sends no heartbeats if it is reliable.

        It waits for room instead, so that the last message is not lost. Zenoh 1.10.2 sends heartbeats from
        the thread that also learns when a socket has room again. While a burst waits for room, a heartbeat
        waits for the burst, and the link is blocked until it is closed a minute later (seen in 1 of 12 runs
        of a thousand goals at once).
        """
        detection = ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=None)
        publisher = ext.declare_advanced_publisher(
            self._zenoh,
            key,
            congestion_control=_congestion(reliable, waits),
            reliability=_reliability(reliable),
            cache=ext.CacheConfig(depth),
            sample_miss_detection=detection if reliable else None,
            publisher_detection=True,
        )
        return _Publisher(publisher, self._put_waiting(key))

    def _put_waiting(self, key: str) -> Callable[..., None]:
        return partial(self._zenoh.put, key, congestion_control=zenoh.CongestionControl.BLOCK)

    def declare_subscriber(
        self,
        key: str,
        on_message: wire.OnMessage,
        *,
        takes_own: bool = True,
        takes_views: bool = False,  # noqa: ARG002 - its payloads are copies
    ) -> wire.Subscriber:
        in_flight = self._in_flight

        def on_sample(raw: zenoh.Sample) -> None:
            keep_thread_state()
            on_message(_message(raw))

        in_flight.enter(on_sample)
        handler = Callback(on_sample, drop=lambda: in_flight.leave(on_sample), indirect=False)
        origin = None if takes_own else zenoh.Locality.REMOTE
        return _Subscriber(self._zenoh.declare_subscriber(key, handler, allowed_origin=origin))

    def declare_queryable(self, key: str, on_query: Callable[[Query], None]) -> wire.Declared:
        in_flight = self._in_flight

        def on_asked(query: zenoh.Query) -> None:
            keep_thread_state()
            on_query(EclipseQuery(query))

        in_flight.enter(on_asked)
        handler = Callback(on_asked, drop=lambda: in_flight.leave(on_asked), indirect=False)
        return _Held(self._zenoh.declare_queryable(key, handler, complete=True))

    def declare_querier(self, key: str) -> wire.Querier:
        return _Querier(self._zenoh, self._in_flight, key)

    def ask_all(
        self,
        key: str,
        parameters: str,
        on_answer: wire.OnAnswer,
        on_end: Callable[[], None],
        *,
        publisher: str,  # noqa: ARG002
        asks_own: bool = True,
    ) -> None:
        asked = _Asked(self._in_flight, on_answer, on_end)
        try:
            self._zenoh.get(
                f'{key}?{parameters}',
                Callback(asked.on_reply, drop=asked.on_drop, indirect=False),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                accept_replies=zenoh.ReplyKeyExpr.ANY,
                allowed_destination=None if asks_own else zenoh.Locality.REMOTE,
            )
        except BaseException:
            self._in_flight.leave(asked)
            raise

    def declare_token(self, token: str) -> wire.Declared:
        return _Held(self._zenoh.liveliness().declare_token(token))

    def watch_tokens(
        self,
        key: str,
        on_token: wire.OnToken,
        *,
        waits: bool,
        own_only: bool = False,  # noqa: ARG002
    ) -> wire.Declared:
        watch = _TokenWatch(self._in_flight, on_token)
        return _Held(watch.start(self._zenoh, key, waits=waits))

    def wait_for_router(self, seconds: float) -> bool:
        if self._zenoh.info.routers_zid() or seconds <= 0:
            return self._is_met()
        met = Event()

        def on_transport(event: zenoh.TransportEvent) -> None:
            if event.transport.whatami == zenoh.WhatAmI.ROUTER:
                met.set()

        handler = Callback(on_transport, indirect=False)
        listener = self._zenoh.info.declare_transport_events_listener(handler, history=True)
        try:
            return met.wait(None if seconds == float('inf') else seconds) or self._is_met()
        finally:
            undeclare(listener)

    def _is_met(self) -> bool:
        info = self._zenoh.info
        return bool(info.routers_zid() or info.peers_zid())

    def watch_routers(self, on_router: Callable[[str, str], None]) -> wire.Declared:
        in_flight = self._in_flight

        def on_link(event: zenoh.LinkEvent) -> None:
            keep_thread_state()
            if event.kind == zenoh.SampleKind.PUT:
                on_router(str(event.link.zid), event.link.dst)

        in_flight.enter(on_link)
        handler = Callback(on_link, drop=lambda: in_flight.leave(on_link), indirect=False)
        return _Held(self._zenoh.info.declare_link_events_listener(handler, history=True))

    def close(self) -> None:
        """Close the session. Zenoh takes up to 10 s for that if a peer does not answer."""
        try:
            self._zenoh.close()  # type: ignore[no-untyped-call]
        finally:
            with suppress(Exception):
                self._in_flight.wait(CLOSING_S)


def _congestion(reliable: bool, waits: bool) -> zenoh.CongestionControl:
    return zenoh.CongestionControl.BLOCK if reliable and waits else zenoh.CongestionControl.DROP


def _reliability(reliable: bool) -> zenoh.Reliability:
    return zenoh.Reliability.RELIABLE if reliable else zenoh.Reliability.BEST_EFFORT
