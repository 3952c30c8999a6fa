"""rclpy.parameter_event_handler: callbacks for changes in the parameters of this and other nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from goalwire.entities.parameters import events as parameter_events
from goalwire.entities.parameters.events import (
    PARAMETER_EVENTS_TOPIC,
    ParameterCallbackHandle,
    ParameterEventCallbackHandle,
    ParameterWatch,
)
from rclpy._reexports import reexport
from rclpy.qos import QoSProfile, qos_profile_parameter_events

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter, ParameterEvent

    from rclpy.callback_groups import CallbackGroup
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.node import Node
    from rclpy.qos_overriding_options import QoSOverridingOptions

__all__ = ['ParameterCallbackHandle', 'ParameterEventCallbackHandle', 'ParameterEventHandler']


class ParameterEventHandler:
    """Listens to /parameter_events until it is destroyed.

    The callback that was added last is called first.
    """

    def __init__(
        self,
        node: Node,
        qos_profile: QoSProfile = qos_profile_parameter_events,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> None:
        """Subscribe to /parameter_events. With `raw` the event callbacks get serialized events."""
        from rcl_interfaces.msg import ParameterEvent

        self.node = node
        self.qos_profile = qos_profile
        self._callbacks = ParameterWatch(node.handle.name)
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            PARAMETER_EVENTS_TOPIC,
            self._callbacks.event_callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )

    def destroy(self) -> None:
        """Stop listening. Idempotent."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    def _resolve_path(self, node_path: str = '') -> str:
        """Return a node's full name; '' means this handler's node.

        Programs call this private method of rclpy.
        """
        return self._callbacks.qualified(node_path)

    @staticmethod
    def get_parameter_from_event(
        event: ParameterEvent, parameter_name: str, node_name: str
    ) -> Parameter | None:
        """Return a node's parameter with the new value in an event; None if it did not change."""
        return parameter_events.parameter_from_event(event, parameter_name, node_name)

    @staticmethod
    def get_parameters_from_event(event: ParameterEvent) -> Iterable[Parameter]:
        """Return the new and the changed parameters in an event."""
        return parameter_events.parameters_from_event(event)

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[Parameter], object]
    ) -> ParameterCallbackHandle:
        """Call `callback(parameter)` when a node's parameter gets a value; '' means this handler's node."""
        return self._callbacks.add_parameter(parameter_name, node_name, callback)

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Forget a callback; raises RuntimeError if it is not registered."""
        self._callbacks.remove_parameter(handle)

    def add_parameter_event_callback(
        self, callback: Callable[[ParameterEvent], object]
    ) -> ParameterEventCallbackHandle:
        """Call `callback(event)` with every event from now on."""
        return self._callbacks.add_event(callback)

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Forget a callback; raises RuntimeError if it is not registered."""
        self._callbacks.remove_event(handle)


reexport(__name__)
