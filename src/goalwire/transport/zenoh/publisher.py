"""Publishers: put, with the history that transient_local asks for (zenoh-wire A.5)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from time import time_ns

import zenoh
from zenoh import ext

from goalwire.errors import TransportError
from goalwire.transport.contract import Endpoint, PublisherPort
from goalwire.transport.place import Place
from goalwire.transport.zenoh.attachment import GID_SIZE, encode
from goalwire.transport.zenoh.config import reason
from goalwire.transport.zenoh.core import Turn, taken_back
from goalwire.transport.zenoh.qos_text import actual_depth


def declare(session: zenoh.Session, key: str, endpoint: Endpoint) -> zenoh.Publisher | ext.AdvancedPublisher:
    """Declare what puts messages on `key` as the endpoint's QoS asks.

    Unlike rmw_zenoh's, a reliable publisher with history sends no heartbeat half a second after a message;
    it waits for room instead, so that no last message is missed. Zenoh 1.10.2 sends heartbeats from the
    thread that also learns when a socket has room again: while a burst waits for room, a heartbeat waits for
    the burst, and nothing moves until the link is given up a minute later (seen in 1 of 12 runs of a
    thousand goals at once).
    """
    qos = endpoint.qos
    waits = endpoint.waits_for_room
    if waits is None:
        waits = qos.keeps_all or qos.is_transient_local
    may_block = qos.is_reliable and waits
    congestion = zenoh.CongestionControl.BLOCK if may_block else zenoh.CongestionControl.DROP
    reliability = zenoh.Reliability.RELIABLE if qos.is_reliable else zenoh.Reliability.BEST_EFFORT
    if not qos.is_transient_local:  # on the wire the same as an advanced publisher without its features
        return session.declare_publisher(key, congestion_control=congestion, reliability=reliability)
    detection = ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=None)
    return ext.declare_advanced_publisher(
        session,
        key,
        congestion_control=congestion,
        reliability=reliability,
        cache=ext.CacheConfig(actual_depth(qos)),
        sample_miss_detection=detection if qos.is_reliable else None,
        publisher_detection=True,
    )


class ZenohPublisher(PublisherPort):
    """A declared publisher.

    Zenoh stamps a message inside `put`. A subscription of rmw_zenoh drops one whose stamp is not newer than
    the last of its session on that key. So all publishers of a session on one key share a `turn`: messages
    are numbered, stamped and sent in one order.
    """

    def __init__(
        self,
        place: Place,
        gid: bytes,
        publisher: zenoh.Publisher | ext.AdvancedPublisher,
        turn: Turn,
    ) -> None:
        self.gid = gid
        self._place = place
        self._put: Callable[..., None] = publisher.put
        self._next_sequence = count(1).__next__
        self._turn = turn

    def publish(self, payload: bytes) -> None:
        """Put one message; all subscriptions get those of several threads in the same order."""
        place = self._place
        if place.closed or place.guard.is_silent:  # in a forked child the turn may be another thread's
            place.check_sending()
        try:
            with self._turn:
                if place.guard.is_silent:  # since then: the turn may have been long in coming
                    place.check_sending()
                self._put(payload, attachment=encode(self._next_sequence(), time_ns(), GID_SIZE, self.gid))
        except (zenoh.ZError, RuntimeError) as error:
            place.check()  # closed by another thread in the meantime
            raise TransportError(f'{place.title}: zenoh refused a message: {reason(error)}') from None

    def release(self) -> None:
        """Let go of the publisher; if another thread is just publishing, it is undeclared when that ends."""
        self._put = taken_back

    def close(self) -> None:
        """Undeclare."""
        self._place.give_up()
