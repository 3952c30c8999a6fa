"""Publishers and subscriptions of serialized messages. They need the type's name, but no message class."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.aio.entity import Entity
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.type_support import find_message_support
from goalwire.errors import ClosedError, InvalidHandle
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Port, PublisherPort, Sample


class RawSubscription(Entity):
    """Receives serialized messages. Made by Node.raw_subscription."""

    def __init__(
        self,
        node: NodeCore,
        topic: str,
        type_name: str,
        type_hash: str,
        qos: QoS,
        deliver: Callable[[Sample], None],
    ) -> None:
        self.name = node.resolve(topic)
        self._node = node
        support = find_message_support(type_name, type_hash)
        endpoint = describe_endpoint(node, EndpointKind.SUBSCRIPTION, self.name, support, qos)
        self._port: Port | None = node.port.subscription(endpoint, deliver)
        node.own(self)

    def close(self) -> None:
        """Stop receiving. Idempotent."""
        port, self._port = self._port, None
        if port is not None:
            self._node.disown(self)
            port.close()

    destroy = close


class RawPublisher(Entity):
    """Publishes serialized messages. Made by Node.raw_publisher."""

    def __init__(self, node: NodeCore, topic: str, type_name: str, type_hash: str, qos: QoS) -> None:
        self.name = node.resolve(topic)
        self._node = node
        support = find_message_support(type_name, type_hash)
        self._endpoint = describe_endpoint(node, EndpointKind.PUBLISHER, self.name, support, qos)
        self._port: PublisherPort | None = node.port.publisher(self._endpoint)
        node.own(self)

    def publish(self, data: bytes) -> None:
        """Send one serialized message. Raises InvalidHandle once closed, ShutDownError."""
        port = self._open_port()
        try:
            port.publish(data)
        except ClosedError:
            raise self._node.context.shutdown_signal.end_error(f"cannot publish on '{self.name}'") from None

    def subscribers(self) -> int:
        """Return how many subscriptions match. Raises InvalidHandle once closed."""
        count = self._open_port().peer_count()
        return len(self._node.graph.find_matched(self._endpoint)) if count is None else count

    def wait_for_acknowledgements(self, timeout_ns: int | None) -> bool:
        """Wait until all reliable subscriptions have every published message; False if the time runs out
        first.

        It blocks the thread that calls it. Raises InvalidHandle once closed.
        """
        return self._open_port().wait_for_acknowledgements(timeout_ns)

    def _open_port(self) -> PublisherPort:
        if self._port is None:
            raise InvalidHandle
        return self._port

    def close(self) -> None:
        """Stop publishing. Idempotent."""
        port, self._port = self._port, None
        if port is not None:
            self._node.disown(self)
            port.close()

    destroy = close
