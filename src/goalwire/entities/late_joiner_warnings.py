"""Warns of a subscription that came after a topic's last message, and waits for that message in vain.

Two mistakes lead to this. A program publishes at its start, before anybody listens, and its publisher keeps
no messages. Or the publisher keeps its last messages, and the subscription does not ask for them.

A false warning does more harm than a missing one. So there is a warning only if the publisher most likely
publishes nothing more: a thread published its messages, and then began to spin without end. If a callback or
another thread publishes, or if the node has a slow timer, the next message may come at any time. There is no
warning, either, if the subscription may have been there before (discovery takes its time), if it has left
again, if a monitoring tool has made it, or if another publisher of the topic serves it.
"""

from __future__ import annotations

from threading import Thread, current_thread
from typing import TYPE_CHECKING

from goalwire.errors import InvalidHandle
from goalwire.execution.time.steady_clock import is_machine_time
from goalwire.execution.time.timer import Timer
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.execution.weak_methods import weakly
from goalwire.logging import get_logger
from goalwire.places import at
from goalwire.rules.qos import DEFAULT, DurabilityPolicy
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from goalwire.entities.node import NodeCore
    from goalwire.graph.watch import CounterpartWatch
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Endpoint, GraphEntity

WAIT_S = 3.0
"""How long, in s, to wait for a further message before the warning."""
_DISCOVERY_NS = 2_000_000_000
"""Once a publisher is older than this, in ns, a subscription that it discovers in another process is new."""
_STARTUP_NS = 30_000_000_000
"""Up to this age, in ns, a publisher that keeps no messages is warned if its first subscription comes too
late.
"""
_MOST = 1000
"""How many subscriptions are remembered."""


class LateJoiners:
    """Looks at the subscriptions that one publisher discovers, until `close`."""

    def __init__(self, node: NodeCore, endpoint: Endpoint, published: Sequence[int]) -> None:
        """The first item of `published` counts the publisher's messages."""
        self._published = published
        self._node = node
        self._endpoint = endpoint
        self._made = self._now()
        self._publishing_thread: Thread | None = None
        self._spinning: set[Thread] = set()
        """The threads that spun before the first message."""
        self._before_spin = 0
        """How many messages the publishing thread had published when it began to spin without end."""
        self._met: set[bytes] = set()
        """The gids of the subscriptions so far: after a cut of the link the same ones are discovered again.
        """
        self._is_done = False
        node.context.shutdown_signal.spin_listeners.add(self)
        self._watch: CounterpartWatch = node.graph.watch_counterparts(
            endpoint.kind, endpoint.name, weakly(self._on_subscription)
        )
        node.remains.add(self._watch.close)

    def on_first_message(self) -> None:
        """Note the calling thread, which publishes, unless it spins: a callback may publish again at any
        time.
        """
        if current_thread() not in self._spinning:
            self._publishing_thread = current_thread()

    def on_spin(self) -> None:
        """Note that the calling thread begins to spin without end."""
        if not self._published[0]:
            self._spinning.add(current_thread())
        elif self._publishing_thread == current_thread() and not self._before_spin:
            self._before_spin = self._published[0]

    def close(self) -> None:
        """Stop looking at subscriptions. Idempotent."""
        self._is_done = True
        self._node.context.shutdown_signal.spin_listeners.discard(self)
        self._node.remains.discard(self._watch.close)
        self._watch.close()

    def _now(self) -> int:
        return self._node.context.shutdown_signal.clock.now()

    def _on_subscription(self, peer: GraphEntity, is_there: bool) -> None:
        if self._is_done or not is_there or peer.type_name != self._endpoint.type_name:
            return
        is_first, is_again = not self._met, peer.gid in self._met
        if len(self._met) < _MOST:
            self._met.add(peer.gid)
        count, age = self._published[0], self._now() - self._made
        is_new = peer.session == self._node.graph.session or age > _DISCOVERY_NS
        is_tool = peer.node.name.startswith('_')  # tools hide their nodes by such names
        if is_again or not count or not is_new or is_tool:
            return
        keeps = self._endpoint.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        if keeps and _is_default(peer.qos):
            self._look_later(peer, count, self._describe_volatile(peer))
        elif not keeps and is_first and age < _STARTUP_NS:
            self._look_later(peer, count, self._describe_lost(peer, count))

    def _look_later(self, peer: GraphEntity, count: int, text: str) -> None:
        """Warn if the subscription still waits in vain after WAIT_S. In virtual time there is no warning."""
        context = self._node.context

        def look() -> None:
            if self._is_done or not context.ok() or not self._waits_in_vain(peer, count):
                return
            self._is_done = True
            place = context.endpoint_places.find(self._endpoint.kind, self._endpoint.name)
            get_logger(self._node.logger_name).warning(f'{text}{at(place)}')

        if is_machine_time(context.shutdown_signal.clock):
            context.deadlines.set(TimerEntry(look), self._now() + int(WAIT_S * 1e9))

    def _waits_in_vain(self, peer: GraphEntity, count: int) -> bool:
        """Whether all `count` messages were published before the spin, and nobody will publish another one
        soon.
        """
        graph, name = self._node.graph, self._endpoint.name
        return (
            count == self._before_spin == self._published[0]
            and graph.count(EndpointKind.PUBLISHER, name) == 1
            and any(other.gid == peer.gid for other in graph.entities(EndpointKind.SUBSCRIPTION, name))
            and not any(_is_slow_timer(owned) for owned in self._node.owned())
        )

    def _describe_volatile(self, peer: GraphEntity) -> str:
        return (
            f"topic '{peer.name}': the subscription in node '{peer.node.qualified}' came after the last "
            'message and does not get it, since that subscription is VOLATILE: if it needs it, write '
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


def _is_default(qos: QoS) -> bool:
    """Whether a subscription has the QoS that a depth alone gives, so that nobody chose VOLATILE."""
    return (qos.reliability, qos.durability) == (DEFAULT.reliability, DEFAULT.durability)


def _is_slow_timer(owned: object) -> bool:
    """Whether an entity is a timer with a period above WAIT_S, which may publish after the warning."""
    try:
        return isinstance(owned, Timer) and not owned.is_canceled() and owned.timer_period_ns > WAIT_S * 1e9
    except InvalidHandle:
        return False  # another thread has just destroyed the timer
