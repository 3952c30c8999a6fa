"""An action as its client reaches it: three services, and what requests to them have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from goalwire.entities.actions.endpoints import ActionQoS
from goalwire.entities.call_context import TimedCalls
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.graph_waiting import tell_near_misses, wait_for_graph
from goalwire.entities.pending_call import NO_REASON, REASONS_LIMIT, end_with
from goalwire.errors import ClosedError, InvalidHandle, ShutDownError
from goalwire.execution.event_queue import ResponseTicks
from goalwire.logging import get_logger
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.requests import ActionRequest, EncodedResponseFuture
    from goalwire.entities.call_context import CallContext
    from goalwire.entities.node import NodeCore
    from goalwire.entities.request_timeout import RequestTimeout
    from goalwire.entities.server_wait_queue import ServerWaitQueue
    from goalwire.entities.type_support import ActionSupport, ServiceSupport
    from goalwire.execution.future import Future
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import ClientPort, Payload, Sample


class ActionCalls(TimedCalls):
    """The services of one action. Its `call_timeout` ends with a goal's acceptance."""

    def __init__(self, node: NodeCore, support: ActionSupport, name: str, qos: ActionQoS) -> None:
        self.node = node
        self.support = support
        self.name = name
        self.requests: dict[ActionRequest, None] = {}
        """Those to take or cancel goals that wait for their answers, or for a server."""
        self._logger = get_logger(node.logger_name).get_child('action_client')
        self._reported: set[tuple[str, str]] = set()
        self._told = ''
        """What was said last of names and types that are near."""
        self.blocking: dict[Future[Any], None] = {}
        """What threads wait for in a call of ours."""
        self._line: ServerWaitQueue | None = None
        self._destroyed = False
        self._names = names = node.resolve_action(name)
        self._send_port = self._client(names.send_goal, support.send_goal, qos.goal)
        self._result_port = self._client(names.get_result, support.get_result, qos.result)
        self._cancel_port = self._client(names.cancel_goal, support.cancel_goal, qos.cancel)
        self._arrivals = ResponseTicks(node.work_queue, self)

    def _client(self, name: str, support: ServiceSupport, qos: QoS) -> ClientPort:
        return self.node.port.client(describe_endpoint(self.node, EndpointKind.CLIENT, name, support, qos))

    # -- requests ------------------------------------------------------------------------------------------

    def request(
        self,
        port: ClientPort,
        payload: bytes,
        on_reply: Callable[[Sample], None],
        on_end: Callable[[str], None],
        timeout_ns: int | None = None,
    ) -> int:
        """Hand a request to the wire and return its number. Raises InvalidHandle, ShutDownError."""
        try:
            return port.request(payload, on_reply, on_end, timeout_ns)
        except ClosedError:
            self._check_alive()
            raise ShutDownError(f"cannot use the action '{self.name}'") from None

    def guard(self, call_context: CallContext, request: ActionRequest) -> RequestTimeout:
        """Make what sees to the end of a request that has terms."""
        from goalwire.entities.request_timeout import RequestTimeout
        from goalwire.entities.server_wait_queue import ServerWaitQueue

        line = self._line
        if line is None:
            line = self._line = ServerWaitQueue(
                self.node.context, self.server_is_there, 'action', self.full_name, self.goal_service
            )
        return RequestTimeout(call_context, line, request, waits=request.waits)

    def new_terms(self, timeout: float | None = None) -> CallContext | None:
        """Terms for a request that may take `timeout` s, else the `default_timeout`; None without either."""
        limit = self.default_timeout if timeout is None else timeout
        if limit is None:
            return None
        from goalwire.entities.call_context import CallContext

        return CallContext(self.node.context, 'action', self.full_name, limit)

    def complete(self, future: EncodedResponseFuture, payload: Payload) -> None:
        """Give a future what it waits for."""
        if future.pending() and not future.set_raw(payload):  # else it was cancelled
            self._arrivals.deliver(None)

    def report_lost(self, what: str, reason: str) -> None:
        """Say once for each kind of request, and each of the first reasons, that nobody will answer it."""
        if self._destroyed or not self.node.context.ok() or self.default_timeout is not None:
            return  # it is this side that goes, or errors tell
        if (what, reason) in self._reported or len(self._reported) == REASONS_LIMIT:
            return
        self._reported.add((what, reason))
        self._logger.warning(
            f"Action '{self.name}': no server answered the {what} ({reason or NO_REASON}). The "
            'future stays pending, as in ROS 2: call wait_for_server() first, and wait with a timeout'
        )

    # -- the server ----------------------------------------------------------------------------------------

    def server_is_there(self) -> bool:
        """True while the graph shows all five parts of a server; False once destroyed.

        Raises ShutDownError after the context's end.
        """
        if self._destroyed:
            return False
        self.node.check_open()
        if not self.node.graph.has_action(self._names.name, self.type_name):
            return False
        return all(port.reaches_server() for port in (self._send_port, self._result_port, self._cancel_port))

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Block until there is a server (True) or the time is over (False); None waits without limit."""
        if wait_for_graph(self.node.context, self.server_is_there, timeout_sec):
            return True
        self._told = tell_near_misses(self.node, 'action', self.full_name, self._told)
        return False

    @property
    def full_name(self) -> str:
        """The action's fully-qualified name."""
        return self._names.name

    @property
    def goal_service(self) -> str:
        """The fully-qualified name of the service that takes goals."""
        return self._names.send_goal

    @property
    def goal_type(self) -> type:
        """The action's Goal class."""
        goal_class: type = self.support.cls.Goal  # type: ignore[attr-defined]
        return goal_class

    @property
    def type_name(self) -> str:
        """'pkg/action/Name'."""
        return self.support.send_goal.type_name.removesuffix('_SendGoal')

    @property
    def destroyed(self) -> bool:
        """True once destroyed."""
        return self._destroyed

    def _check_alive(self) -> None:
        if self._destroyed:
            raise InvalidHandle

    def _close_calls(self) -> None:
        """Undeclare; requests with terms, or that threads wait for, end with InvalidHandle.

        Others stay as they are.
        """
        for asked in (*self.requests,):
            if asked.guard is not None:
                asked.guard.fail(InvalidHandle())
        for future in (*self.blocking,):
            if future.pending():
                end_with(future, InvalidHandle())
        for port in (self._send_port, self._result_port, self._cancel_port):
            port.close()
        self._arrivals.close()
        self.requests.clear()
