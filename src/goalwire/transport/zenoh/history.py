"""Subscriptions with history: every publisher is asked for what it keeps, then followed (zenoh-wire A.5).

On the wire what zenoh's advanced subscriber does: publishers with history show a token
`<key>/@adv/pub/<session>/<entity>/_` and answer queries there (`_max=<depth>`, `_sn=<first>..<last>`);
reliable ones number their messages and may send heartbeats on the same key. Others say 'uhlc' for the entity.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import NamedTuple

import zenoh

from goalwire.transport.contract import Sample
from goalwire.transport.outbox import Outbox
from goalwire.transport.zenoh.core import Core, Declared, undeclare
from goalwire.transport.zenoh.stream import Stream
from goalwire.transport.zenoh.thread_state import pin

UNNUMBERED = 'uhlc'
"""The entity chunk of publishers whose messages have no number of the wire."""

KEPT_STREAMS = 1000
"""How many publishers are remembered; beyond, those that have gone are forgotten, the oldest first."""

_NUMBER_SIZE = 4
Read = Callable[[zenoh.Sample], Sample | None]


class _Came(NamedTuple):
    """Where a message came from: the publisher's address, None where it has none, and its number."""

    address: str | None
    number: int
    is_first: bool


def _came(raw: zenoh.Sample, sample: Sample) -> _Came:
    info = raw.source_info
    if info is not None:
        source = info.source_id
        return _Came(f'{source.zid}/{source.eid}', info.source_sn, info.source_sn == 0)
    stamp = raw.timestamp
    address = None if stamp is None else f'{stamp.get_id()}/{UNNUMBERED}'
    return _Came(address, sample.sequence, sample.sequence == 1)


class HistorySubscriber:
    """One declared subscription; `read` drops what breaks the rules."""

    def __init__(
        self, core: Core, key: str, depth: int, read: Read, deliver: Callable[[Sample], None]
    ) -> None:
        self._core = core
        self._key = key
        self._depth = depth
        self._read = read
        self._deliver = deliver
        self._recovers = False
        self._origin: zenoh.Locality | None = None
        self._lock = Lock()  # over the streams, never over calls of zenoh or of `deliver`
        self._streams: dict[str, Stream[Sample]] = {}
        self._outbox: Outbox[Sample] = Outbox(self._tell)
        self._declared: list[Declared] = []
        self._is_open = True

    def declare(self, *, recovers: bool, origin: zenoh.Locality | None) -> None:
        """Follow the publishers within `origin`; where it `recovers`, what is missing is asked for again."""
        self._recovers, self._origin = recovers, origin
        try:
            self._declare_all()
        except BaseException:
            self.undeclare()
            raise

    def _declare_all(self) -> None:
        session, of_publishers = self._core.zenoh, f'{self._key}/@adv/pub/**'
        live = session.declare_subscriber(
            self._key, self._callback(self._on_live), allowed_origin=self._origin
        )
        self._declared.append(live)
        tokens, on_token = session.liveliness(), self._callback(self._on_token)
        self._declared.append(tokens.declare_subscriber(of_publishers, on_token, history=True))
        if self._recovers:
            beat = self._callback(self._on_heartbeat)
            self._declared.append(
                session.declare_subscriber(of_publishers, beat, allowed_origin=self._origin)
            )
        source = live.id
        self._declared.append(tokens.declare_token(f'{self._key}/@adv/sub/{source.zid}/{source.eid}/_'))

    def undeclare(self) -> None:
        """Take everything off the wire."""
        self._is_open = False
        while self._declared:
            undeclare(self._declared.pop())

    def _callback(self, take: Callable[[zenoh.Sample], None]) -> zenoh.handlers.Callback[zenoh.Sample]:
        in_flight = self._core.in_flight

        def on_sample(raw: zenoh.Sample) -> None:
            pin()
            take(raw)

        in_flight.enter(on_sample)
        return zenoh.handlers.Callback(on_sample, drop=lambda: in_flight.leave(on_sample), indirect=False)

    def _tell(self, sample: Sample) -> None:
        if self._is_open:
            self._deliver(sample)

    def _stream(self, address: str) -> Stream[Sample]:
        """Return the stream of an address, a new one where it was not known; under the lock."""
        stream = self._streams.get(address)
        if stream is None:
            if len(self._streams) >= KEPT_STREAMS:
                self._forget_one()
            numbered = not address.endswith(f'/{UNNUMBERED}')
            stream = Stream(self._outbox.post, self._depth, numbered=numbered, recovers=self._recovers)
            self._streams[address] = stream
        return stream

    def _forget_one(self) -> None:
        for address, stream in self._streams.items():
            if not (stream.is_alive or stream.is_asking):
                del self._streams[address]
                return

    def _on_live(self, raw: zenoh.Sample) -> None:
        sample = self._read(raw)
        if sample is None:
            return
        address, number, is_first = _came(raw, sample)
        if address is None:
            self._tell(sample)
            return
        with self._lock:
            stream = self._stream(address)
            question = stream.live(sample.gid, number, sample, is_first=is_first)
        self._outbox.drain()
        self._ask(address, stream, question)

    def _on_token(self, raw: zenoh.Sample) -> None:
        address = self._address(raw)
        with self._lock:
            stream = self._stream(address)
            stream.is_alive = raw.kind == zenoh.SampleKind.PUT
            question = stream.ask() if stream.is_alive else None
        self._ask(address, stream, question)

    def _on_heartbeat(self, raw: zenoh.Sample) -> None:
        payload = raw.payload.to_bytes()
        if len(payload) != _NUMBER_SIZE:
            return
        address = self._address(raw)
        with self._lock:
            stream = self._stream(address)
            question = stream.heartbeat(int.from_bytes(payload, 'little'))
        self._ask(address, stream, question)

    def _address(self, raw: zenoh.Sample) -> str:
        """Return the two chunks of '<key>/@adv/pub/<session>/<entity>/…'."""
        chunks = str(raw.key_expr).removeprefix(f'{self._key}/@adv/pub/').split('/')
        return '/'.join(chunks[:2])

    def _ask(self, address: str, stream: Stream[Sample], question: str | None) -> None:
        """Put a question to the publishers of an address; their answers may come before this returns."""
        if question is None:
            return

        def on_answer(reply: zenoh.Reply) -> None:
            pin()
            sample = None if reply.ok is None else self._read(reply.ok)
            if reply.ok is not None and sample is not None:
                number = _came(reply.ok, sample).number
                with self._lock:
                    stream.answer(sample.gid, number, sample)
                self._outbox.drain()

        def on_end() -> None:
            pin()
            with self._lock:
                stream.end()
            self._outbox.drain()
            self._core.in_flight.leave(on_answer)

        self._core.in_flight.enter(on_answer)
        try:
            self._core.zenoh.get(
                f'{self._key}/@adv/pub/{address}/**?{question}',
                zenoh.handlers.Callback(on_answer, drop=on_end, indirect=False),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                accept_replies=zenoh.ReplyKeyExpr.ANY,
                allowed_destination=self._origin,
            )
        except zenoh.ZError:  # the session is closing
            on_end()
