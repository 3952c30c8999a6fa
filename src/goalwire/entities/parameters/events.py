"""/parameter_events: publishes the changes of this node's parameters, and reads those of other nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.entities.standard_types import standard_message
from goalwire.errors import UnknownCallbackError

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterEvent

    from goalwire.entities.node import NodeCore
    from goalwire.entities.publisher import PublisherCore
    from goalwire.rules.parameters import Changes
    from goalwire.transport.contract import NodeName

    OnParameter: TypeAlias = Callable[[ParameterMessage], object]
    OnEvent: TypeAlias = Callable[[ParameterEvent], object]


PARAMETER_EVENTS_TOPIC = '/parameter_events'
PARAMETER_EVENT = 'rcl_interfaces/msg/ParameterEvent'


class ParameterEvents:
    """Publishes parameter events. They are volatile, so no message is made while nobody subscribes."""

    def __init__(self, node: NodeCore, publisher: PublisherCore[Any]) -> None:
        self._node = node
        self._publisher = publisher

    def publish(self, changes: Changes) -> None:
        """Publish the changes of one set of parameters."""
        if not changes or self._publisher.destroyed or not self._node.context.ok():
            return
        if self._publisher.subscription_count():
            self._publisher.publish(self._message(changes))

    def _message(self, changes: Changes) -> object:
        from rcl_interfaces.msg import ParameterEvent

        return ParameterEvent(
            stamp=self._node.clock.now().to_stamp(),
            node=self._node.name.qualified,
            new_parameters=[parameter.to_parameter_msg() for parameter in changes.new],
            changed_parameters=[parameter.to_parameter_msg() for parameter in changes.changed],
            deleted_parameters=[parameter.to_parameter_msg() for parameter in changes.deleted],
        )


class ParameterCallbackHandle:
    """One callback for one parameter of one node."""

    def __init__(self, parameter_name: str, node_name: str, callback: OnParameter) -> None:
        self.parameter_name = parameter_name
        self.node_name = node_name
        self.callback = callback


class ParameterEventCallbackHandle:
    """One callback that gets every event."""

    def __init__(self, callback: OnEvent) -> None:
        self.callback = callback


class ParameterWatch:
    """Hands each event to its callbacks; the callback added last is called first.

    `parameter_callbacks`, `event_callbacks` and `event_callback` are rclpy's names: its programs read them.
    """

    def __init__(self, node: NodeName) -> None:
        self._node = node
        self.parameter_callbacks: dict[tuple[str, str], list[ParameterCallbackHandle]] = {}
        """The callbacks by the names of the parameter and of its node."""
        self.event_callbacks: list[ParameterEventCallbackHandle] = []

    def event_callback(self, event: ParameterEvent | bytes) -> None:
        """Call the callbacks that want an event; event callbacks get a serialized event as it is."""
        decoded: ParameterEvent = (
            standard_message(PARAMETER_EVENT).decode(event) if isinstance(event, bytes) else event
        )
        for (name, node_name), handles in list(self.parameter_callbacks.items()):
            parameter = parameter_from_event(decoded, name, node_name)
            if parameter is not None:
                for handle in tuple(handles):
                    handle.callback(parameter)
        for watcher in tuple(self.event_callbacks):
            watcher.callback(event)  # type: ignore[arg-type]  # serialized if the caller asked for that

    def add_parameter(self, name: str, node_name: str, callback: OnParameter) -> ParameterCallbackHandle:
        """Call `callback(parameter)` with each new value; `node_name` may be relative, '' is this node."""
        handle = ParameterCallbackHandle(name, self.qualified(node_name), callback)
        self.parameter_callbacks.setdefault((name, handle.node_name), []).insert(0, handle)
        return handle

    def add_event(self, callback: OnEvent) -> ParameterEventCallbackHandle:
        """Call `callback(event)` with each event of every node."""
        handle = ParameterEventCallbackHandle(callback)
        self.event_callbacks.insert(0, handle)
        return handle

    def remove_parameter(self, handle: ParameterCallbackHandle) -> None:
        """Forget a callback; raises UnknownCallbackError."""
        key = handle.parameter_name, handle.node_name
        handles = self.parameter_callbacks.get(key, [])
        if handle not in handles:
            raise UnknownCallbackError
        handles.remove(handle)
        if not handles:
            del self.parameter_callbacks[key]

    def remove_event(self, handle: ParameterEventCallbackHandle) -> None:
        """Forget a callback; raises UnknownCallbackError."""
        if handle not in self.event_callbacks:
            raise UnknownCallbackError
        self.event_callbacks.remove(handle)

    def qualified(self, node_name: str) -> str:
        """Return the full name of a node: '' is this node; a relative name is in this node's namespace."""
        if not node_name:
            return self._node.qualified
        if node_name.startswith('/'):
            return node_name
        return f'{self._node.namespace.rstrip("/")}/{node_name}'


def parameters_from_event(event: ParameterEvent) -> Iterator[ParameterMessage]:
    """Return the new parameters of an event, then the changed ones."""
    yield from event.new_parameters
    yield from event.changed_parameters


def parameter_from_event(event: ParameterEvent, name: str, node_name: str) -> ParameterMessage | None:
    """Return the new value of a parameter of a node, None if the event does not concern it."""
    if event.node != node_name:
        return None
    return next((found for found in parameters_from_event(event) if found.name == name), None)
