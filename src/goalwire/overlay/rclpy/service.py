"""rclpy.service: answers requests."""

from __future__ import annotations

from functools import cached_property
from typing import Generic

from goalwire.entities.service import ServiceCore
from goalwire.entities.type_support import RequestT, ResponseT, ServiceClass
from goalwire.transport.contract import Request
from rclpy._reexports import reexport
from rclpy.callback_groups import CallbackGroup
from rclpy.impl.endpoint import ServiceEndpoint


class Service(ServiceCore, ServiceEndpoint, Generic[RequestT, ResponseT]):
    """Serves one service. Made by Node.create_service."""

    callback_group: CallbackGroup

    @cached_property
    def srv_type(self) -> ServiceClass[RequestT, ResponseT]:
        """The service class. For a node's built-in services the class is made at its first use."""
        return self.support.cls

    def service_take_request(
        self, srv_request_type: type[RequestT]
    ) -> tuple[RequestT, Request] | tuple[None, None]:
        """Take a waiting request and its header, like rclpy's handle; return (None, None) if none waits."""
        return self.take() or (None, None)


reexport(__name__)
