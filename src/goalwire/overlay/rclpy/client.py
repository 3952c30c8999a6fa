"""rclpy.client: calls services."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic

from goalwire.entities.client import ClientCore
from goalwire.entities.pending_call import PendingCall
from goalwire.entities.type_support import RequestT, ResponseT, ServiceClass
from rclpy._reexports import reexport
from rclpy.impl.endpoint import ServiceEndpoint
from rclpy.task import Future


class BaseClient(ClientCore, ServiceEndpoint, Generic[RequestT, ResponseT]):
    """The common base of Client and AsyncClient."""

    srv_type: ServiceClass[RequestT, ResponseT]

    def service_is_ready(self) -> bool:
        """True while there is a server with the client's service name and type."""
        return self.server_is_there()


class Client(BaseClient[RequestT, ResponseT]):
    """Calls one service. Made by Node.create_client."""

    if TYPE_CHECKING:  # ClientCore's methods, typed for this service's messages
        # With `...` as the body, pylint would assume that the function returns None.

        def call(self, request: RequestT, timeout_sec: float | None = None) -> ResponseT | Any:
            raise NotImplementedError

        def call_async(self, request: RequestT) -> Future[ResponseT]:
            raise NotImplementedError

    def get_pending_request(self, sequence_number: int) -> Future[ResponseT]:
        """Return the future of an unanswered request; raises KeyError for any other number."""
        return self.pending[sequence_number]

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Stop waiting for the response to a request; the request's future stays pending."""
        if isinstance(future, PendingCall):
            future.discard()


reexport(__name__)
