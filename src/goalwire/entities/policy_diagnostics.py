"""/diagnostics: what the policy of this program has refused (diagnostic_msgs/DiagnosticArray).

Nothing is published before the first refusal. From then on there is one message a second until the program
ends, as diagnostic_updater publishes: diagnostic_aggregator takes a status for stale after 5 s without news.
A status is a warning for RECENT_S after the latest refusal to its identity, and OK afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol
from weakref import ref

from goalwire.cdr import codec
from goalwire.entities.endpoint import InGraph, describe_endpoint
from goalwire.entities.standard_types import standard_message
from goalwire.errors import ClosedError, ForkedError, GoalwireError
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.rules.qos import QoS
from goalwire.security.refusal_counts import RECENT_S, RefusalCounts, RefusedActs
from goalwire.transport.contract import EndpointKind, PublisherPort

if TYPE_CHECKING:
    from goalwire.execution.time.clock import ROSClock
    from goalwire.execution.time.timer_heap import TimerThread
    from goalwire.transport.contract import NodePort

TOPIC = '/diagnostics'
ARRAY = 'diagnostic_msgs/msg/DiagnosticArray'
MOST_VALUES = 20
"""How many refused acts a status names: those that were refused most often."""


class PublishingNode(InGraph, Protocol):
    """A node through which diagnostics are published."""

    clock: ROSClock

    @property
    def port(self) -> NodePort:
        """The node on the wire, through which endpoints are declared."""

    @property
    def destroyed(self) -> bool:
        """True once the node is destroyed."""

    def resolve(self, name: str) -> str:
        """Return the fully-qualified name of a topic."""


class PolicyDiagnostics:
    """Publishes the refusals of one context's session, through the first of its nodes."""

    def __init__(self, refusals: RefusalCounts, sends: TimerThread, is_open: Callable[[], bool]) -> None:
        """`sends` is the thread that publishes; `is_open` returns False once the context has ended."""
        self._refusals = refusals
        self._sends = sends
        self._is_open = is_open
        self._nodes: list[Callable[[], PublishingNode | None]] = []
        self._port: PublisherPort | None = None
        self._entry = TimerEntry(self._publish)
        refusals.listen(self)

    def join(self, node: PublishingNode) -> None:
        """Publish through a node, if those that joined earlier have gone."""
        self._nodes.append(ref(node))

    def tell(self) -> None:
        """Have another thread publish the refusals soon."""
        # Another thread publishes: that may wait for room on the wire, which the calling thread makes.
        self._sends.soon(self._entry)

    def _publish(self) -> None:
        if not self._is_open():
            return
        try:
            if self._port is None:
                self._port = self._open()
            if self._port is not None:
                self._port.publish(codec.encode(self._message()))
        except (ClosedError, ForkedError):
            self._port = None  # the node has gone: the next node takes over
        except GoalwireError as error:
            from goalwire.logging import get_logger

            get_logger('goalwire.security').warning(f"'{TOPIC}' is not published: {error}", once=True)

    def _open(self) -> PublisherPort | None:
        """Declare the publisher; None if there is no node."""
        while self._nodes:
            node = self._nodes[0]()
            if node is not None and not node.destroyed:
                support, name = standard_message(ARRAY), node.resolve(TOPIC)
                endpoint = describe_endpoint(
                    node, EndpointKind.PUBLISHER, name, support, QoS(), waits_for_room=False
                )
                return node.port.publisher(endpoint)
            del self._nodes[0]
        return None

    def _message(self) -> Any:
        from diagnostic_msgs.msg import DiagnosticArray

        message = DiagnosticArray()
        nodes = filter(None, (node() for node in self._nodes))
        message.header.stamp = next(nodes).clock.now().to_msg()
        message.status = [self._status(each) for each in self._refusals.report()]
        return message

    def _status(self, refused: RefusedActs) -> Any:
        from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

        count = sum(refused.counts.values())
        is_recent = refused.age_s < RECENT_S
        most = sorted(refused.counts.items(), key=lambda each: -each[1])[:MOST_VALUES]
        times = 'once' if count == 1 else f'{count} times'
        return DiagnosticStatus(
            level=DiagnosticStatus.WARN if is_recent else DiagnosticStatus.OK,
            name=f'{self._refusals.identity}: refused to {refused.who}',
            message=f'refused {times}: {refused.reason}',
            hardware_id=self._refusals.identity,
            values=[KeyValue(key=act, value=str(number)) for act, number in most],
        )


def publish_through(
    node: PublishingNode, refusals: RefusalCounts, sends: TimerThread, is_open: Callable[[], bool]
) -> None:
    """Publish what a node's session refuses; the parameters are those of PolicyDiagnostics."""
    known = (each for each in refusals.listeners if isinstance(each, PolicyDiagnostics))
    diagnostics = next(known, None) or PolicyDiagnostics(refusals, sends, is_open)
    diagnostics.join(node)
