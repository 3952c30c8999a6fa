"""One of an action server's three services. Its calls can be recorded, as those of any service."""

from __future__ import annotations

from typing import TYPE_CHECKING

from goalwire.entities.recorder_watch import watch_recorders
from goalwire.entities.request_server import RequestServer
from goalwire.entities.service_introspection import Introspected, Step
from goalwire.transport.contract import Request

if TYPE_CHECKING:
    from goalwire.entities.service_introspection import ServiceIntrospection


class ActionService(RequestServer, Introspected):
    """A request server that reports its calls to recorders."""

    destroyed = False

    def open(self) -> None:
        """Begin to take requests, as `RequestServer.open` does."""
        super().open()
        watch_recorders(self)

    def _handle(self, request: Request) -> object:
        introspection = self.introspection
        if introspection is not None and not self.destroyed:
            request = ReportedRequest(request, introspection)
        return super()._handle(request)

    def destroy(self) -> None:
        """Undeclare the service; waiting requests are cancelled. Idempotent."""
        super().destroy()
        self.end_introspection()


class ReportedRequest(Request):
    """A request that reports its arrival and its answer to recorders."""

    __slots__ = ('_introspection', '_request', 'sample')

    def __init__(self, request: Request, introspection: ServiceIntrospection) -> None:
        self.sample = request.sample
        self._request = request
        self._introspection = introspection
        self._tell(Step.REQUEST_RECEIVED, introspection.decode_request(request.sample.payload))

    def reply(self, payload: bytes) -> None:
        self._request.reply(payload)
        self._tell(Step.RESPONSE_SENT, self._introspection.decode(payload))

    def cancel(self, reason: str = '') -> None:
        self._request.cancel(reason)

    def _tell(self, step: Step, message: object) -> None:
        self._introspection.report(step, self.sample.gid, self.sample.sequence, message)
