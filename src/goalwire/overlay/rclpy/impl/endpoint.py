"""The common base of publishers, subscriptions, clients and services in rclpy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from goalwire.errors import InvalidHandle
from goalwire.execution.handle import handle_of
from rclpy.clock import Clock
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.rules.qos import QoS
    from rclpy.event_handler import EventHandler


class Endpoint:
    """Mixed into an entity of goalwire.entities, which does the work. Its block ends with its destruction."""

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
        """Its handle, as rclpy's programs use it. A `with` block of it does not destroy the entity."""
        return handle_of(self)

    @property
    def logger_name(self) -> str:
        """The name of its node's logger, as in newer rclpy; raises InvalidHandle once destroyed."""
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
    """The handlers of its events: the program's own and the default ones."""

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
        """The name as it was given."""
        return self.name

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Publish each step of calls on `<service>/_service_event`, or stop that (OFF).

        Raises TypeError for what is not a state, InvalidHandle once destroyed.
        """
        self.introspect(clock, service_event_qos_profile.to_core(), introspection_state)


class Adopted:
    """An entity of an AsyncNode, to be mixed in first.

    The node learns of its destruction, and cancels its callbacks.
    """

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """End it, and cancel the callbacks that run, save one that calls this. Idempotent."""
        super().destroy()  # type: ignore[misc]  # the entity's
        if self.on_destroy is not None:
            self.on_destroy()
