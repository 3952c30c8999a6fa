"""Subscriptions: what arrives becomes a Sample and is delivered where it was read (zenoh-wire A.5, A.9)."""

from __future__ import annotations

from collections.abc import Callable

from goalwire.errors import RemoteError
from goalwire.transport.contract import Endpoint, Sample
from goalwire.transport.endpoint import EndpointState
from goalwire.transport.zenoh.context import Declared, ZenohContext
from goalwire.transport.zenoh.history import HistorySubscriber
from goalwire.transport.zenoh.keyexpr import CPU_BUFFERS
from goalwire.transport.zenoh.qos_text import actual_depth
from goalwire.transport.zenoh.samples import sample_of
from goalwire.transport.zenoh.tokens import uses_cpu_channel
from goalwire.transport.zenoh.wire import Message, OnMessage


def declare(
    context: ZenohContext,
    state: EndpointState,
    key: str,
    endpoint: Endpoint,
    deliver: Callable[[Sample], None],
) -> list[Declared]:
    """Declare what brings messages of `key` to `deliver`: one subscriber, or two for types with buffers."""
    reject = _rejecter(context, state)
    takes_own = not endpoint.ignore_local
    if endpoint.qos.is_transient_local:
        subscriber = HistorySubscriber(context, key, actual_depth(endpoint.qos), _reader(reject), deliver)
        subscriber.declare(recovers=endpoint.qos.is_reliable, takes_own=takes_own)
        return [subscriber]
    keys = [key]
    if uses_cpu_channel(endpoint):  # each message comes through exactly one of the two
        keys.append(f'{key}/{CPU_BUFFERS}')
    return [
        context.wire.declare_subscriber(each, _handler(reject, deliver), takes_own=takes_own) for each in keys
    ]


def _rejecter(context: ZenohContext, state: EndpointState) -> Callable[[RemoteError], None]:
    """Return what counts a message that breaks the rules."""
    return lambda error: context.rejects.add('message', error, state)


def _reader(reject: Callable[[RemoteError], None]) -> Callable[[Message], Sample | None]:
    """Return what makes a Sample of the wire's, or None of one that is rejected."""

    def read_sample(raw: Message) -> Sample | None:
        try:
            return sample_of(raw)
        except RemoteError as error:
            reject(error)
            return None

    return read_sample


def _handler(reject: Callable[[RemoteError], None], deliver: Callable[[Sample], None]) -> OnMessage:
    def on_message(raw: Message) -> None:
        try:
            sample = sample_of(raw)
        except RemoteError as error:
            reject(error)
            return
        deliver(sample)

    return on_message
