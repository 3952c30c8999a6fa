"""rclpy.time_source: sets a node's clocks from /clock under `use_sim_time`."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import ReferenceType, ref

from goalwire.entities.time_source import CLOCK_TOPIC, USE_SIM_TIME_NAME, TimeSourceCore
from rclpy._reexports import reexport
from rclpy.clock import ROSClock

if TYPE_CHECKING:
    from rclpy.impl.base_node import BaseNode

__all__ = ['CLOCK_TOPIC', 'USE_SIM_TIME_NAME', 'TimeSource']


class TimeSource(TimeSourceCore):
    """Follows the parameter `use_sim_time` of a node."""

    def __init__(self, *, node: BaseNode | None = None) -> None:
        super().__init__()
        self._node: ReferenceType[BaseNode] | None = None
        if node is not None:
            self.attach_node(node)

    def attach_node(self, node: BaseNode) -> None:
        """Follow `node`'s parameter, declared here where it is not yet; a node from before is left.

        Raises TypeError for what is no node.
        """
        from rclpy.impl.base_node import BaseNode

        if not isinstance(node, BaseNode):
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
        """Listen to /clock no more; the clocks keep their time."""
        self._unsubscribe()
        node = self._attached()
        if node is not None:
            node.remove_post_set_parameters_callback(self._follow)
        self._node = None

    def attach_clock(self, clock: ROSClock) -> None:
        """Set `clock` too. Raises ValueError where it is of another kind than ROS_TIME."""
        if not isinstance(clock, ROSClock):
            raise ValueError('Only clocks with type ROS_TIME can be attached.')  # noqa: TRY004 - rclpy's own
        super().attach_clock(clock)

    def _attached(self) -> BaseNode | None:
        return None if self._node is None else self._node()

    def _subscribe(self) -> None:
        node = self._attached()
        if node is None or self.subscription is not None:
            return
        from rclpy.impl.clock_subscription import subscribe_to_clock

        self.subscription = subscribe_to_clock(node, self)

    def _unsubscribe(self) -> None:
        node, subscription = self._attached(), self.subscription
        self.subscription = None
        if node is not None and subscription is not None:
            from rclpy.impl.clock_subscription import unsubscribe_from_clock

            unsubscribe_from_clock(node, subscription)


reexport(__name__)
