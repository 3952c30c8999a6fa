"""/parameter_events: what changed in a node's parameters (rcl_interfaces/msg/ParameterEvent)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.publisher import PublisherCore
    from goalwire.rules.parameters import Changes

PARAMETER_EVENTS_TOPIC = '/parameter_events'
PARAMETER_EVENT = 'rcl_interfaces/msg/ParameterEvent'


class ParameterEvents:
    """Tells whoever listens. The messages are not even made where nobody does: they are volatile."""

    def __init__(self, node: NodeCore, publisher: PublisherCore[Any]) -> None:
        self._node = node
        self._publisher = publisher

    def publish(self, changes: Changes) -> None:
        """Publish what a set did."""
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
