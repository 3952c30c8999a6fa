"""Subscriptions: what arrives becomes a Sample and is delivered on zenoh's thread (zenoh-wire A.5, A.9)."""

from __future__ import annotations

from collections.abc import Callable
from time import time_ns

import zenoh

from goalwire.errors import RemoteError
from goalwire.transport.contract import Endpoint, Port, Sample, new_sample
from goalwire.transport.place import Place
from goalwire.transport.zenoh.attachment import read
from goalwire.transport.zenoh.core import Core, Declared
from goalwire.transport.zenoh.history import HistorySubscriber
from goalwire.transport.zenoh.keyexpr import CPU_BUFFERS
from goalwire.transport.zenoh.qos_text import actual_depth
from goalwire.transport.zenoh.thread_state import pin
from goalwire.transport.zenoh.tokens import uses_cpu_channel


def declare(core: Core, key: str, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> list[Declared]:
    """Declare what brings messages of `key` to `deliver`: one subscriber, or two for types with buffers."""
    read = _reader(core, endpoint.name)
    origin = zenoh.Locality.REMOTE if endpoint.ignore_local else None
    if endpoint.qos.is_transient_local:
        subscriber = HistorySubscriber(core, key, actual_depth(endpoint.qos), read, deliver)
        subscriber.declare(recovers=endpoint.qos.is_reliable, origin=origin)
        return [subscriber]
    keys = [key]
    if uses_cpu_channel(endpoint):  # each message comes through exactly one of the two
        keys.append(f'{key}/{CPU_BUFFERS}')
    return [
        core.zenoh.declare_subscriber(each, _handler(core, read, deliver), allowed_origin=origin)
        for each in keys
    ]


def _reader(core: Core, name: str) -> Callable[[zenoh.Sample], Sample | None]:
    """Return what makes a Sample of zenoh's, or None, counted, of one that breaks the rules."""

    def read_sample(sample: zenoh.Sample) -> Sample | None:
        received = time_ns()
        try:
            sequence, sent, gid = read(sample.attachment)
        except RemoteError as error:
            core.rejects.add('message', f"on topic '{name}': {error}")
            return None
        return new_sample((sample.payload.to_bytes(), sequence, sent, received, gid))

    return read_sample


def _handler(
    core: Core, read: Callable[[zenoh.Sample], Sample | None], deliver: Callable[[Sample], None]
) -> zenoh.handlers.Callback[zenoh.Sample]:
    def on_sample(raw: zenoh.Sample) -> None:
        pin()
        sample = read(raw)
        if sample is not None:
            deliver(sample)

    def on_drop() -> None:
        core.in_flight.leave(on_sample)

    core.in_flight.enter(on_sample)
    return zenoh.handlers.Callback(on_sample, drop=on_drop, indirect=False)


class ZenohSubscription(Port):
    """A declared subscription."""

    def __init__(self, place: Place, gid: bytes) -> None:
        self.gid = gid
        self._place = place

    def close(self) -> None:
        """Undeclare."""
        self._place.give_up()
