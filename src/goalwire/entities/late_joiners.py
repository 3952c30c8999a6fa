"""Tells of a subscription that came after the last message, and waits for it in vain.

Two mistakes lead there. A program publishes once, before anybody listens, and its publisher keeps nothing. Or
the publisher keeps its last messages, and the subscription does not ask for them. Neither is told if another
message comes soon, nor if the subscription may have been there before: discovery takes its time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.unspun import tells_at_end
from goalwire.execution.monotonic import is_machine_time
from goalwire.execution.timer_heap import TimerEntry
from goalwire.execution.weak_methods import weakly
from goalwire.logging import get_logger
from goalwire.places import at
from goalwire.rules.qos import DurabilityPolicy

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.entities.node import NodeCore
    from goalwire.graph.watch import CounterpartWatch
    from goalwire.transport.contract import Endpoint, GraphEntity

WAIT_S = 3.0
"""How long the next message has time to come."""
_DISCOVERY_NS = 2_000_000_000
"""How old a publisher is when a subscription of another process that it discovers must be new."""
_STARTUP_NS = 30_000_000_000
"""Up to which age of a publisher that keeps nothing it counts as a mistake that it has published before."""


class LateJoiners:
    """Looks at the subscriptions that one publisher discovers, until `close`."""

    def __init__(self, node: NodeCore, endpoint: Endpoint, published: Sequence[int]) -> None:
        """The first item of `published` counts the publisher's messages."""
        self._published = published
        self._node = node
        self._endpoint = endpoint
        self._made = self._now()
        self._is_told = self._was_met = False
        self._watch: CounterpartWatch = self._node.graph.watch_counterparts(
            endpoint.kind, endpoint.name, weakly(self._on_subscription)
        )
        self._node.remains.add(self._watch.close)

    def close(self) -> None:
        """Look no more. Idempotent."""
        self._node.remains.discard(self._watch.close)
        self._watch.close()

    def _now(self) -> int:
        return self._node.context.shutdown_signal.clock.now()

    def _on_subscription(self, peer: GraphEntity, is_there: bool) -> None:
        if self._is_told or not is_there or peer.type_name != self._endpoint.type_name:
            return
        was_met, self._was_met = self._was_met, True
        count, age = self._published[0], self._now() - self._made
        is_new = peer.session == self._node.graph.session or age > _DISCOVERY_NS
        if not count or not is_new or peer.node.name.startswith('_'):  # tools hide their nodes by that
            return
        keeps = self._endpoint.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        if keeps and peer.qos.durability is DurabilityPolicy.VOLATILE:
            self._look_later(count, self._describe_volatile(peer))
        elif not keeps and not was_met and age < _STARTUP_NS:
            self._look_later(count, self._describe_lost(peer, count))

    def _look_later(self, count: int, text: str) -> None:
        """Tell unless another message is published soon. In virtual time nothing is told."""
        context = self._node.context

        def look() -> None:
            if self._published[0] != count or self._is_told or not (context.ok() or tells_at_end()):
                return
            self._is_told = True
            place = context.endpoint_places.find(self._endpoint.kind, self._endpoint.name)
            get_logger(self._node.logger_name).warning(f'{text}{at(place)}')

        if is_machine_time(context.shutdown_signal.clock):
            context.deadlines.set(TimerEntry(look), self._now() + int(WAIT_S * 1e9))

    def _describe_volatile(self, peer: GraphEntity) -> str:
        return (
            f"topic '{peer.name}': the subscription in node '{peer.node.qualified}' came after the last "
            'message and does not get it, since that subscription is VOLATILE: write '
            'durability=DurabilityPolicy.TRANSIENT_LOCAL in its QoSProfile, as the publisher has it'
        )

    def _describe_lost(self, peer: GraphEntity, count: int) -> str:
        messages, them = ('1 message was', 'it') if count == 1 else (f'{count} messages were', 'them')
        return (
            f"topic '{peer.name}': {messages} published before the subscription in node "
            f"'{peer.node.qualified}' was there, which does not get {them}: publish again when it is there, "
            'as in a timer, or write durability=DurabilityPolicy.TRANSIENT_LOCAL in the QoSProfile of both, '
            'so that the last messages are kept'
        )
