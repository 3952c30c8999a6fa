"""The subscription of /clock as a node lists it; imported when simulated time is switched on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.time_source import CLOCK_QOS, ClockSubscription
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

if TYPE_CHECKING:
    from goalwire.entities.time_source import TimeSourceCore
    from rclpy.impl.base_node import BaseNode


class ListedClockSubscription(ClockSubscription, Subscription[Any]):
    """One of Node.subscriptions, as in rclpy."""


def subscribe_to_clock(node: BaseNode, source: TimeSourceCore) -> ListedClockSubscription:
    """Make the subscription; jump callbacks run in the node's default callback group."""
    group = node._default_callback_group  # noqa: SLF001
    subscription = ListedClockSubscription(node.handle, group, source)
    subscription.qos_profile = QoSProfile(depth=CLOCK_QOS.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
    subscription.callback_group = group
    group.add_entity(subscription)
    node._subscriptions.append(subscription)  # noqa: SLF001 - what Node.create_subscription does
    return subscription


def unsubscribe_from_clock(node: BaseNode, subscription: ClockSubscription) -> None:
    """Destroy the subscription."""
    listed: list[Any] = node._subscriptions  # noqa: SLF001
    if subscription in listed:
        listed.remove(subscription)
    subscription.destroy()
