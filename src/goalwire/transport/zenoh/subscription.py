"""Subscriptions: what arrives becomes a Sample and is delivered on zenoh's thread (zenoh-wire A.5, A.9)."""

from __future__ import annotations

from collections.abc import Callable
from time import time_ns

import zenoh
from zenoh import ext

from goalwire.errors import RemoteError
from goalwire.protocol.qos import QoS
from goalwire.transport.contract import Endpoint, Port, Sample
from goalwire.transport.place import Place
from goalwire.transport.zenoh.attachment import read
from goalwire.transport.zenoh.core import Core
from goalwire.transport.zenoh.keyexpr import CPU_BUFFERS
from goalwire.transport.zenoh.qos_text import actual_depth
from goalwire.transport.zenoh.thread_state import pin
from goalwire.transport.zenoh.tokens import uses_cpu_channel

Subscriber = zenoh.Subscriber[None] | ext.AdvancedSubscriber[None]


def declare(core: Core, key: str, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> list[Subscriber]:
    """Declare what brings messages of `key` to `deliver`: one subscriber, or two for types with buffers."""
    subscribers = [_declare_one(core, key, endpoint, deliver)]
    if uses_cpu_channel(endpoint):  # each message comes through exactly one of the two
        subscribers.append(_declare_one(core, f'{key}/{CPU_BUFFERS}', endpoint, deliver))
    return subscribers


def _declare_one(core: Core, key: str, endpoint: Endpoint, deliver: Callable[[Sample], None]) -> Subscriber:
    handler = _handler(core, endpoint.name, deliver)
    origin = zenoh.Locality.REMOTE if endpoint.ignore_local else None
    if endpoint.qos.is_transient_local:
        return _declare_with_history(core.zenoh, key, endpoint.qos, handler, origin)
    return core.zenoh.declare_subscriber(key, handler, allowed_origin=origin)


def _declare_with_history(
    session: zenoh.Session,
    key: str,
    qos: QoS,
    handler: zenoh.handlers.Callback[zenoh.Sample],
    origin: zenoh.Locality | None,
) -> Subscriber:
    recovery = ext.RecoveryConfig(periodic_queries=None, heartbeat=True)
    return ext.declare_advanced_subscriber(
        session,
        key,
        handler,
        allowed_origin=origin,
        history=ext.HistoryConfig(detect_late_publishers=True, max_samples=actual_depth(qos)),
        recovery=recovery if qos.is_reliable else None,
        subscriber_detection=True,
    )


def _handler(
    core: Core, name: str, deliver: Callable[[Sample], None]
) -> zenoh.handlers.Callback[zenoh.Sample]:
    def on_sample(sample: zenoh.Sample) -> None:
        pin()
        received = time_ns()
        try:
            sequence, sent, gid = read(sample.attachment)
        except RemoteError as error:
            core.rejects.add('message', f"on topic '{name}': {error}")
            return
        deliver(Sample(sample.payload.to_bytes(), sequence, sent, received, gid))

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
