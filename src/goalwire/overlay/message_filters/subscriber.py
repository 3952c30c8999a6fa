"""The source of a chain of filters: a subscription of a node."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription

from message_filters.simple_filter import SimpleFilter

__all__ = ['Subscriber']

DEFAULT_DEPTH = 10


class Subscriber(SimpleFilter):
    """A subscription whose messages go to the registered callbacks.

    Takes the arguments of Node.create_subscription except the callback, and has the subscription's
    attributes.
    """

    def __init__(
        self, node: Node, msg_type: type, topic: str, qos_profile: Any = DEFAULT_DEPTH, **kwargs: Any
    ) -> None:
        """Subscribe to the topic; raises as Node.create_subscription does."""
        super().__init__()
        self.node = node
        self.topic = topic
        self.sub: Subscription[Any] = node.create_subscription(
            msg_type, topic, self.callback, qos_profile=qos_profile, **kwargs
        )

    def callback(self, msg: object) -> None:
        """Pass a received message to the registered callbacks."""
        self.signalMessage(msg)

    def getTopic(self) -> str:
        """Return the topic's name as the program gave it."""
        return self.topic

    def __getattr__(self, name: str) -> Any:
        if name == 'sub':  # create_subscription has failed
            raise AttributeError(name)
        return getattr(self.sub, name)
