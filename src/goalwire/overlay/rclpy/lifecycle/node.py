"""rclpy.lifecycle.node: managed nodes, which other nodes configure, activate and shut down."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar, cast

from goalwire.entities.lifecycle.managed_entity import ManagedEntity
from goalwire.entities.lifecycle.managed_node import LifecycleCore, LifecycleServices
from goalwire.rules.lifecycle import (
    ACTIVATE,
    CLEANUP,
    CONFIGURE,
    DEACTIVATE,
    LifecycleMachine,
    LifecycleState,
    TransitionCallbackReturnType,
)
from rclpy._reexports import reexport
from rclpy.lifecycle.managed_entity import TransitionCallbackReturn
from rclpy.lifecycle.publisher import LifecyclePublisher
from rclpy.node import Node
from rclpy.publisher import Publisher

if TYPE_CHECKING:
    from goalwire.entities.service import ServiceCore
    from rclpy.callback_groups import CallbackGroup
    from rclpy.qos import QoSProfile

__all__ = ['LifecycleNode', 'LifecycleNodeMixin', 'LifecycleState', 'TransitionCallbackReturn']

MsgT = TypeVar('MsgT')


class StateMachine:
    """The part of rclpy's `node._state_machine` that programs read: a node has no public name for it.

    The services are None if the node has no communication interface.
    """

    def __init__(self, machine: LifecycleMachine, services: Sequence[ServiceCore | None]) -> None:
        self._machine = machine
        (
            self.service_change_state,
            self.service_get_state,
            self.service_get_available_states,
            self.service_get_available_transitions,
            self.service_get_transition_graph,
        ) = services

    @property
    def current_state(self) -> tuple[int, str]:
        """The present state's id and label."""
        return self._machine.state.state_id, self._machine.state.label


class LifecycleNodeMixin(ManagedEntity):
    """Makes a Node a managed node: `class Mine(LifecycleNodeMixin, Node)`. Initialize Node before the mixin.

    The transition callbacks (on_configure and so on) call the same callbacks of the managed entities, in the
    order in which the entities were added, until one does not return SUCCESS. Programs override the node's
    callbacks, and call super() to extend them.
    """

    def __init__(
        self, *, enable_communication_interface: bool = True, callback_group: CallbackGroup | None = None
    ) -> None:
        """Publish transition events; offer services if `enable_communication_interface` is true.

        Raises TypeError if it is not a bool.
        """
        if not isinstance(enable_communication_interface, bool):
            raise TypeError(
                f'enable_communication_interface of a lifecycle node: expected bool, '
                f'got {type(enable_communication_interface).__name__}'
            )
        node = self._ros_as_node()
        clock = node.get_clock()
        self._ros_lifecycle = LifecycleCore(node.handle, self, lambda: clock.now().nanoseconds)
        services: Sequence[ServiceCore | None] = [None] * 5
        if enable_communication_interface:
            services = LifecycleServices(self._ros_lifecycle).offer(callback_group)
        self._state_machine = StateMachine(self._ros_lifecycle.machine, services)

    def _ros_as_node(self) -> Node:
        return cast('Node', self)

    def trigger_configure(self) -> TransitionCallbackReturnType:
        """Configure the node, which makes it inactive; raises RCLError if that is not allowed now."""
        return self._ros_lifecycle.trigger(CONFIGURE)

    def trigger_cleanup(self) -> TransitionCallbackReturnType:
        """Clean up the inactive node, which makes it unconfigured; raises as trigger_configure does."""
        return self._ros_lifecycle.trigger(CLEANUP)

    def trigger_shutdown(self) -> TransitionCallbackReturnType:
        """Shut the node down, which makes it finalized; raises as trigger_configure does."""
        return self._ros_lifecycle.trigger_shutdown()

    def trigger_activate(self) -> TransitionCallbackReturnType:
        """Activate the inactive node; raises as trigger_configure does."""
        return self._ros_lifecycle.trigger(ACTIVATE)

    def trigger_deactivate(self) -> TransitionCallbackReturnType:
        """Deactivate the active node; raises as trigger_configure does."""
        return self._ros_lifecycle.trigger(DEACTIVATE)

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Add an entity that follows the transitions; raises TypeError for anything but a ManagedEntity."""
        self._ros_lifecycle.add(entity)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_configure of each managed entity."""
        return self._ros_lifecycle.call_entities('on_configure', state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_cleanup of each managed entity."""
        return self._ros_lifecycle.call_entities('on_cleanup', state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_shutdown of each managed entity."""
        return self._ros_lifecycle.call_entities('on_shutdown', state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_activate of each managed entity."""
        return self._ros_lifecycle.call_entities('on_activate', state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_deactivate of each managed entity."""
        return self._ros_lifecycle.call_entities('on_deactivate', state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturnType:
        """Call on_error of each managed entity."""
        return self._ros_lifecycle.call_entities('on_error', state)

    def create_lifecycle_publisher(
        self, msg_type: type[MsgT], topic: str, qos_profile: QoSProfile | int, **kwargs: Any
    ) -> LifecyclePublisher[MsgT]:
        """Create a publisher that publishes only while the node is active.

        The arguments are those of create_publisher. Raises as create_publisher does, and TypeError for
        `publisher_class`.
        """
        if 'publisher_class' in kwargs:
            raise TypeError("create_publisher() got an unexpected keyword argument 'publisher_class'")
        publisher = self._ros_as_node().create_publisher(
            msg_type, topic, qos_profile, publisher_class=LifecyclePublisher, **kwargs
        )
        assert isinstance(publisher, LifecyclePublisher)
        self._ros_lifecycle.add(publisher)
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[Any]) -> bool:
        """Destroy a publisher of this node; False if the node does not have it."""
        self._ros_lifecycle.remove(publisher)
        return self._ros_as_node().destroy_publisher(publisher)


class LifecycleNode(LifecycleNodeMixin, Node):
    """A managed node. Takes the arguments of Node, and `enable_communication_interface`."""

    def __init__(self, node_name: str, *, enable_communication_interface: bool = True, **kwargs: Any) -> None:
        """Construct the node; raises as Node does."""
        Node.__init__(self, node_name, **kwargs)
        LifecycleNodeMixin.__init__(self, enable_communication_interface=enable_communication_interface)

    def destroy_publisher(self, publisher: Publisher[Any]) -> bool:
        """Destroy a publisher of this node, managed or unmanaged; False if the node does not have it."""
        if isinstance(publisher, LifecyclePublisher):
            self._ros_lifecycle.remove(publisher)
        return Node.destroy_publisher(self, publisher)


reexport(__name__)
