"""rclpy.time_source: sets a node's clocks from /clock under `use_sim_time`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from weakref import ReferenceType, ref

from goalwire.entities.parameters.node_parameters import NodeParameters
from goalwire.entities.time_source import (
    CLOCK_QOS,
    CLOCK_TOPIC,
    USE_SIM_TIME_NAME,
    ClockSubscription,
    TimeSourceCore,
)
from rclpy._reexports import reexport
from rclpy.clock import ROSClock
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

if TYPE_CHECKING:
    from rclpy.callback_groups import CallbackGroup

__all__ = ['CLOCK_TOPIC', 'USE_SIM_TIME_NAME', 'TimeSource']


class ListedClockSubscription(ClockSubscription, Subscription[Any]):
    """The subscription to /clock in a form that Node.subscriptions can list, as in rclpy."""


class ClockedNode(NodeParameters):
    """A node that a time source can follow; jump callbacks run in its default callback group."""

    if TYPE_CHECKING:

        @property
        def default_callback_group(self) -> CallbackGroup:
            """The mutually exclusive group of all callbacks that have no other group."""


class TimeSource(TimeSourceCore):
    """Sets clocks from /clock while a node's parameter `use_sim_time` is true."""

    def __init__(self, *, node: ClockedNode | None = None) -> None:
        super().__init__()
        self._node: ReferenceType[ClockedNode] | None = None
        if node is not None:
            self.attach_node(node)

    def attach_node(self, node: ClockedNode) -> None:
        """Follow `node`'s parameter `use_sim_time`, and declare it if necessary; detach an earlier node.

        Raises TypeError for anything but a node.
        """
        if not isinstance(node, ClockedNode):
            raise TypeError('Node must be of type rclpy.node.Node')
        if self._node is not None:
            self.detach_node()
        self._node = ref(node)
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        self._follow([node.get_parameter(USE_SIM_TIME_NAME)])
        node.add_post_set_parameters_callback(self._follow)
        if self._active:
            self._subscribe()

    def detach_node(self) -> None:
        """Stop listening to /clock; the clocks keep their present time."""
        self._unsubscribe()
        node = self._get_node()
        if node is not None:
            node.remove_post_set_parameters_callback(self._follow)
        self._node = None

    def attach_clock(self, clock: ROSClock) -> None:
        """Also set `clock` from now on. Raises ValueError if its clock type is not ROS_TIME."""
        if not isinstance(clock, ROSClock):
            raise ValueError('Only clocks with type ROS_TIME can be attached.')  # noqa: TRY004 - rclpy's own
        super().attach_clock(clock)

    @property
    def _clock_sub(self) -> ClockSubscription | None:
        """The subscription to /clock, or None. Programs read this private name of rclpy."""
        return self.subscription

    def _get_node(self) -> ClockedNode | None:
        return None if self._node is None else self._node()

    def _subscribe(self) -> None:
        node = self._get_node()
        if node is None or self.subscription is not None:
            return
        group = node.default_callback_group
        self.subscription = subscription = ListedClockSubscription(node.handle, group, self)
        best_effort = ReliabilityPolicy.BEST_EFFORT
        subscription.qos_profile = QoSProfile(depth=CLOCK_QOS.depth, reliability=best_effort)
        subscription.callback_group = group
        group.add_entity(subscription)

    def _unsubscribe(self) -> None:
        subscription, self.subscription = self.subscription, None
        if subscription is not None:
            subscription.destroy()


reexport(__name__)
