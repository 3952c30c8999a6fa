"""Subscriptions: each message becomes a Sample and is delivered on the thread that read it.

A subscription with history asks every publisher for its kept messages, then follows it. On the wire it
behaves as zenoh's advanced subscriber. Publishers with history show a token
`<key>/@adv/pub/<session>/<entity>/_` and answer queries there (`_max=<depth>`, `_sn=<first>..<last>`).
Reliable ones number their messages and may send heartbeats on the same key; the others have 'uhlc' in place
of the entity.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from time import monotonic, time_ns
from typing import NamedTuple

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.errors import RemoteError
from goalwire.transport.contract import Endpoint, Sample, new_sample
from goalwire.transport.endpoint import EndpointState
from goalwire.transport.zenoh import wire
from goalwire.transport.zenoh.attachment import GID_SIZE, SIZE, sample_of, split
from goalwire.transport.zenoh.context import ZenohContext
from goalwire.transport.zenoh.ros_keys import CPU_BUFFERS, actual_depth, uses_cpu_channel
from goalwire.transport.zenoh.stream import StreamState
from goalwire.transport.zenoh.wire import Declared, Message, OnMessage, undeclare
from goalwire.zenoh.protocol.network import ReplyError
from goalwire.zenoh.protocol.primitives import show_id

UNNUMBERED = 'uhlc'
"""The chunk in place of the entity, for publishers that do not number their messages on the wire."""

KEPT_STREAMS = 1000
"""How many publishers are remembered. Beyond this number, gone publishers are forgotten, the oldest first."""

_NUMBER_SIZE = 4
Read = Callable[[Message], Sample | None]


class _Came(NamedTuple):
    """The origin of a message: the publisher's address if it is known, and the message's number."""

    address: str | None
    number: int
    is_first: bool


def _came(raw: Message, sample: Sample) -> _Came:
    info = raw.source_info
    if info is not None:
        return _Came(f'{show_id(info.zid)}/{info.entity}', info.number, info.number == 0)
    stamp = raw.timestamp
    address = None if stamp is None else f'{show_id(stamp.zid)}/{UNNUMBERED}'
    return _Came(address, sample.sequence, sample.sequence == 1)


class HistorySubscriber:
    """One declared subscription; `read` drops messages that break the rules."""

    def __init__(
        self, context: ZenohContext, key: str, depth: int, read: Read, deliver: Callable[[Sample], None]
    ) -> None:
        self._context = context
        self._key = key
        self._depth = depth
        self._read = read
        self._deliver = deliver
        self._recovers = False
        self._takes_own = True
        self._lock = RLock()  # protects the streams; not held during calls of zenoh or of `deliver`
        self._streams: dict[str, StreamState[Sample]] = {}
        self._dispatcher: OrderedDispatcher[Sample] = OrderedDispatcher(self._tell)
        self._declared: list[Declared] = []
        self._is_open = True

    def declare(self, *, recovers: bool, takes_own: bool) -> None:
        """Follow the publishers; with `takes_own` also those of this session.

        With `recovers` missing messages are requested again.
        """
        self._recovers, self._takes_own = recovers, takes_own
        try:
            self._declare_all()
        except BaseException:
            self.undeclare()
            raise

    def _declare_all(self) -> None:
        wire, of_publishers = self._context.wire, f'{self._key}/@adv/pub/**'
        live = wire.declare_subscriber(self._key, self._on_live, takes_own=self._takes_own)
        self._declared.append(live)
        self._declared.append(wire.watch_tokens(of_publishers, self._on_token, waits=False))
        if self._recovers:
            beat = wire.declare_subscriber(of_publishers, self._on_heartbeat, takes_own=self._takes_own)
            self._declared.append(beat)
        self._declared.append(wire.declare_token(f'{self._key}/@adv/sub/{live.address}/_'))

    def undeclare(self) -> None:
        """Undeclare everything."""
        self._is_open = False
        while self._declared:
            undeclare(self._declared.pop())

    def _tell(self, sample: Sample) -> None:
        if self._is_open:
            self._deliver(sample)

    def _stream(self, address: str) -> StreamState[Sample]:
        """Return the stream of an address, a new one if it was unknown. The caller holds the lock."""
        stream = self._streams.get(address)
        if stream is None:
            if len(self._streams) >= KEPT_STREAMS:
                self._discard_one()
            numbered = not address.endswith(f'/{UNNUMBERED}')
            stream = StreamState(
                self._dispatcher.post, self._depth, numbered=numbered, recovers=self._recovers
            )
            self._streams[address] = stream
        return stream

    def _discard_one(self) -> None:
        for address, stream in list(self._streams.items()):
            if not (stream.is_alive or stream.is_asking):
                self._streams.pop(address, None)
                return

    def _on_live(self, raw: Message) -> None:
        sample = self._read(raw)
        if sample is None:
            return
        address, number, is_first = _came(raw, sample)
        if address is None:
            self._tell(sample)
            return
        with self._lock:
            stream = self._stream(address)
            if stream.is_asking and monotonic() - stream.asked_s > wire.HISTORY_S:
                stream.end()
            question = stream.live(sample.gid, number, sample, is_first=is_first)
        self._dispatcher.drain()
        self._ask(address, stream, question)

    def _on_token(self, token: str, is_there: bool) -> None:
        address = self._address(token)
        with self._lock:
            stream = self._stream(address)
            stream.is_alive = is_there
            question = stream.ask() if stream.is_alive else None
        self._ask(address, stream, question)

    def _on_heartbeat(self, raw: Message) -> None:
        payload = raw.payload
        if payload is None or len(payload) != _NUMBER_SIZE:
            return
        address = self._address(raw.key)
        with self._lock:
            stream = self._stream(address)
            question = stream.heartbeat(int.from_bytes(payload, 'little'))
        self._ask(address, stream, question)

    def _address(self, key: str) -> str:
        """Return '<session>/<entity>' from '<key>/@adv/pub/<session>/<entity>/…'."""
        chunks = key.removeprefix(f'{self._key}/@adv/pub/').split('/')
        return '/'.join(chunks[:2])

    def _ask(self, address: str, stream: StreamState[Sample], question: str | None) -> None:
        """Send a query to the publishers of an address. Their answers may come before this returns."""
        if question is None:
            return

        def on_answer(reply: Message | ReplyError) -> None:
            if isinstance(reply, ReplyError):
                return
            sample = self._read(reply)
            if sample is not None:
                number = _came(reply, sample).number
                with self._lock:
                    stream.answer(sample.gid, number, sample)
                self._dispatcher.drain()

        stream.asked_s = asked_s = monotonic()

        def stop_waiting() -> None:
            with self._lock:
                if stream.asked_s == asked_s:  # if not, a later query is open
                    stream.end()
            self._dispatcher.drain()

        cancel = self._context.wire.call_later(wire.HISTORY_S, stop_waiting)

        def on_end() -> None:
            cancel()
            stop_waiting()

        try:
            self._context.wire.ask_all(
                f'{self._key}/@adv/pub/{address}/**',
                question,
                on_answer,
                on_end,
                publisher=address.partition('/')[0],
                asks_own=self._takes_own,
            )
        except self._context.errors:  # the session is closing
            on_end()


def declare(
    context: ZenohContext,
    state: EndpointState,
    key: str,
    endpoint: Endpoint,
    deliver: Callable[[Sample], None],
) -> list[Declared]:
    """Declare a subscriber that gives messages of `key` to `deliver`, or two if the type has buffers."""
    reject = _rejecter(context, state)
    takes_own = not endpoint.ignore_local
    if endpoint.qos.is_transient_local:
        subscriber = HistorySubscriber(context, key, actual_depth(endpoint.qos), _reader(reject), deliver)
        subscriber.declare(recovers=endpoint.qos.is_reliable, takes_own=takes_own)
        return [subscriber]
    keys = [key]
    if uses_cpu_channel(endpoint):  # each message comes on only one of the two keys
        keys.append(f'{key}/{CPU_BUFFERS}')
    return [
        context.wire.declare_subscriber(
            each, _handler(reject, deliver), takes_own=takes_own, takes_views=endpoint.takes_views
        )
        for each in keys
    ]


def _rejecter(context: ZenohContext, state: EndpointState) -> Callable[[RemoteError], None]:
    """Return a function that counts messages which break the rules."""
    return lambda error: context.rejects.add('message', error, state)


def _reader(reject: Callable[[RemoteError], None]) -> Callable[[Message], Sample | None]:
    """Return a function that makes a Sample from a message of the wire, or None if it is rejected."""

    def read_sample(raw: Message) -> Sample | None:
        try:
            return sample_of(raw)
        except RemoteError as error:
            reject(error)
            return None

    return read_sample


def _handler(reject: Callable[[RemoteError], None], deliver: Callable[[Sample], None]) -> OnMessage:
    def on_message(raw: Message) -> None:
        # hot path: this is `sample_of` for the ordinary attachment, and saves a call for each message.
        data, payload = raw.attachment, raw.payload
        if data is not None and len(data) == SIZE and payload is not None:
            sequence, sent, size, gid = split(data)
            if size == GID_SIZE and sequence >= 0 and sent >= 0:
                deliver(new_sample((payload, sequence, sent, time_ns(), gid)))
                return
        try:
            sample = sample_of(raw)
        except RemoteError as error:
            reject(error)
            return
        deliver(sample)

    return on_message
