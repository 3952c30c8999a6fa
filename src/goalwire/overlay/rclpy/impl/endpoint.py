"""The common base of publishers, subscriptions, clients and services in rclpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from goalwire.errors import InvalidHandle
from goalwire.execution.rclpy_handle import handle_of
from rclpy.clock import Clock
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from rclpy.event_handler import EventHandler


class Endpoint:
    """A mixin that gives rclpy's attributes to entities of goalwire.entities.

    A `with` block destroys them.
    """

    qos_profile: QoSProfile

    if TYPE_CHECKING:
        full_name: str
        node: NodeCore

        @property
        def destroyed(self) -> bool:
            """True once destroyed."""

        def destroy(self) -> None:
            """Release the endpoint. Idempotent."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()

    @property
    def handle(self) -> Self:
        """The handle that rclpy's programs use. A `with` block of the handle does not destroy the entity."""
        return handle_of(self)

    @property
    def logger_name(self) -> str:
        """The name of the node's logger, as in newer rclpy; raises InvalidHandle once destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self.node.logger_name

    def _checked_name(self) -> str:
        if self.destroyed:
            raise InvalidHandle
        return self.full_name


class TopicEndpoint(Endpoint):
    """A publisher or a subscription."""

    event_handlers: Sequence[EventHandler] = ()
    """The handlers of the endpoint's events: the program's and the default handlers."""

    @property
    def topic_name(self) -> str:
        """The fully-qualified name; raises InvalidHandle once destroyed."""
        return self._checked_name()


class ServiceEndpoint(Endpoint):
    """A client or a service."""

    if TYPE_CHECKING:
        name: str

        def introspect(self, clock: Clock, qos: QoS, state: ServiceIntrospectionState) -> None:
            """Publish service events; see goalwire.entities.service_introspection."""

    @property
    def service_name(self) -> str:
        """The fully-qualified name; raises InvalidHandle once destroyed."""
        return self._checked_name()

    @property
    def srv_name(self) -> str:
        """The service's name as it was given to the constructor."""
        return self.name

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Publish each step of service calls on `<service>/_service_event`, or stop publishing (state OFF).

        Raises TypeError for an invalid state, InvalidHandle once destroyed.
        """
        self.introspect(clock, service_event_qos_profile.to_core(), introspection_state)


class Adopted:
    """A mixin for entities of an AsyncNode; it must be the first base class.

    When the entity is destroyed, the node is notified, and cancels the entity's callbacks.
    """

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """Destroy the entity and cancel its running callbacks, except one that calls `destroy`.

        Idempotent.
        """
        super().destroy()  # type: ignore[misc]  # the entity's
        if self.on_destroy is not None:
            self.on_destroy()
