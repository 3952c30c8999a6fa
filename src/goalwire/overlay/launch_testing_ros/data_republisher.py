"""launch_testing_ros.data_republisher: changes a topic's messages and publishes them on another topic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from rclpy.node import Node

__all__ = ['DataRepublisher']

MsgT = TypeVar('MsgT')


class DataRepublisher(Generic[MsgT]):
    """Applies a function to each message of a topic and publishes the result, while the node spins."""

    def __init__(
        self,
        node: Node,
        listen_topic: str,
        publish_topic: str,
        msg_type: type[MsgT],
        transform_fn: Callable[[MsgT], MsgT | None],
    ) -> None:
        """Begin to republish messages. If `transform_fn` returns None, the message is dropped."""
        self._node = node
        self._transform = transform_fn
        self._received = 0
        self._republished: list[MsgT] = []
        self._publisher = node.create_publisher(msg_type, publish_topic, 10)
        self._subscription = node.create_subscription(msg_type, listen_topic, self._pass_on, 10)

    def shutdown(self) -> None:
        """Stop republishing."""
        self._node.destroy_subscription(self._subscription)
        self._node.destroy_publisher(self._publisher)

    def get_num_received(self) -> int:
        """Return how many messages were received."""
        return self._received

    def get_num_republished(self) -> int:
        """Return how many messages were published; dropped ones do not count."""
        return len(self._republished)

    def get_republished(self) -> list[MsgT]:
        """Return the received messages that were republished. `transform_fn` may have changed them."""
        return self._republished

    def _pass_on(self, message: MsgT) -> None:
        self._received += 1
        changed = self._transform(message)
        if changed is not None:
            self._republished.append(message)
            self._publisher.publish(changed)
