"""Shared by relay, throttle, drop and mux: republishing a topic of any type."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosidl_runtime_py.utilities import get_message

LOOKING_S = 0.1
"""Seconds between two checks for a publisher, because rclpy has no callback for new publishers."""


class Input:
    """An input topic. Its subscription takes type and QoS from the publishers, and begins with the first one.

    `open_output` is called with the message class and a QoS before the first message, and `take` with each
    message in CDR.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        open_output: Callable[[type, QoSProfile], None],
        take: Callable[[bytes], None],
    ) -> None:
        self.topic = node.resolve_topic_name(topic)
        self._node = node
        self._open_output = open_output
        self._take = take
        self._subscription: Subscription[Any] | None = None
        self._looking = node.create_timer(LOOKING_S, self._look)
        self._look()

    def _look(self) -> None:
        infos = self._node.get_publishers_info_by_topic(self.topic)
        if not infos:
            return
        self._looking.cancel()
        kinds = {info.topic_type for info in infos}
        if len(kinds) > 1:
            found = ', '.join(sorted(kinds))
            self._node.get_logger().warning(
                f'{self.topic} has several types, {found}: only the first is used'
            )
        try:
            message: type = get_message(infos[0].topic_type)
        except (AttributeError, ModuleNotFoundError, ValueError) as error:
            self._node.get_logger().error(f'the type of {self.topic} is unknown here: {error}')
            return
        qos = _matching([info.qos_profile for info in infos])
        self._open_output(message, qos)
        self._subscription = self._node.create_subscription(message, self.topic, self._take, qos, raw=True)

    def close(self) -> None:
        """Stop listening."""
        self._looking.cancel()
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None


class Output:
    """A topic that is published once its type is known."""

    def __init__(self, node: Node, topic: str) -> None:
        self.topic = node.resolve_topic_name(topic)
        self._node = node
        self._publisher: Publisher[Any] | None = None
        self._kind: Any = None

    def open(self, message: type, qos: QoSProfile) -> None:
        """Publish messages of this class from now on. A second class is refused with a line in the log."""
        if self._publisher is None:
            self._kind = message
            self._publisher = self._node.create_publisher(message, self.topic, qos)
            self._node.get_logger().info(f'{self.topic} is published')
        elif message is not self._kind:
            self._node.get_logger().error(
                f'{self.topic} has the type {self._kind.__name__}: messages of {message.__name__} do not fit'
            )

    def send(self, serialized: bytes) -> None:
        """Publish a message that is already serialized."""
        if self._publisher is not None:
            self._publisher.publish(serialized)


def _matching(offered: list[QoSProfile]) -> QoSProfile:
    """Return a QoS that matches every publisher: best effort or volatile if at least one of them is."""
    best_effort = any(qos.reliability == ReliabilityPolicy.BEST_EFFORT for qos in offered)
    volatile = any(qos.durability == DurabilityPolicy.VOLATILE for qos in offered)
    return QoSProfile(
        depth=max([10, *(qos.depth for qos in offered)]),
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.VOLATILE if volatile else DurabilityPolicy.TRANSIENT_LOCAL,
    )
