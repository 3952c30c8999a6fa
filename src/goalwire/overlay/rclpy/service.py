"""rclpy.service: answers requests."""

from __future__ import annotations

from functools import cached_property
from types import TracebackType
from typing import Generic, Self, TypeVar

from goalwire.entities.exceptions import InvalidHandle
from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import ServiceType
from goalwire.transport.contract import Request
from rclpy._borrowed import borrow
from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock
from rclpy.qos import QoSProfile
from rclpy.service_introspection import ServiceIntrospectionState

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class Service(ServiceCore, Generic[RequestT, ResponseT]):
    """Made by Node.create_service."""

    qos_profile: QoSProfile
    callback_group: CallbackGroup

    @cached_property
    def srv_type(self) -> type[ServiceType[RequestT, ResponseT]]:
        """The service class; those of a node's standing services are made when first asked for."""
        return self.support.cls

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

    def service_take_request(self, srv_request_type: type[RequestT]) -> tuple[RequestT, Request] | None:
        """Take a request and its header, as rclpy's handle offers it to waitables; else None."""
        return self.take()

    @property
    def handle(self) -> Self:
        """The service itself: there is no C handle behind it."""
        return self

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, exc_type: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.destroy()


borrow(__name__)
