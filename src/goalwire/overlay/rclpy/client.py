"""rclpy.client: calls services."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

from goalwire.entities.client import ClientCore, ResponseFuture
from goalwire.entities.exceptions import InvalidHandle
from goalwire.entities.type_support import ServiceType
from rclpy._borrowed import borrow
from rclpy.clock import Clock
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.task import Future

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class BaseClient(ClientCore, Generic[RequestT, ResponseT]):
    """What Client and AsyncClient share."""

    srv_type: type[ServiceType[RequestT, ResponseT]]
    qos_profile: QoSProfile

    def service_is_ready(self) -> bool:
        """True while there is a server of this name and type."""
        return self.server_is_there()

    def configure_introspection(
        self,
        clock: Clock,
        service_event_qos_profile: QoSProfile,
        introspection_state: ServiceIntrospectionState,
    ) -> None:
        """Publish each step of calls on `<service>/_service_event`, or stop that (OFF).

        Raises TypeError for what is no state, InvalidHandle once destroyed.
        """
        self.introspect(clock, service_event_qos_profile.to_core(), introspection_state)

    @property
    def service_name(self) -> str:
        """The fully-qualified name; raises InvalidHandle once destroyed."""
        if self.destroyed:
            raise InvalidHandle
        return self.full_name

    @property
    def srv_name(self) -> str:
        """The name as it was given."""
        return self.name

    @property
    def handle(self) -> Self:
        """The client itself: there is no C handle behind it."""
        return self

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()


class Client(BaseClient[RequestT, ResponseT]):
    """Made by Node.create_client."""

    if TYPE_CHECKING:  # what ClientCore does, with the types of this service

        def call(self, request: RequestT, timeout_sec: float | None = None) -> ResponseT | None: ...

        def call_async(self, request: RequestT) -> Future[ResponseT]: ...

    def get_pending_request(self, sequence_number: int) -> Future[ResponseT]:
        """Return the future of an unanswered request; raises KeyError."""
        return self.pending[sequence_number]

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Wait for a response no longer; its future stays pending."""
        if isinstance(future, ResponseFuture):
            future.forget()


borrow(__name__)
