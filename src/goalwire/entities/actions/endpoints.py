"""The three services and two topics of an action server."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from goalwire.entities.actions.action_service import ActionService
from goalwire.entities.endpoint import describe_endpoint
from goalwire.entities.names import ResolvedAction
from goalwire.entities.node import NodeCore
from goalwire.entities.type_support import ActionSupport, MessageSupport, ServiceSupport
from goalwire.execution.callback_groups import CallbackGroup
from goalwire.records import record
from goalwire.rules.goals import wire
from goalwire.rules.qos import ACTION_STATUS_DEFAULT, DEFAULT, SERVICES_DEFAULT, QoS
from goalwire.transport.contract import EndpointKind, Payload, PublisherPort, Request

Handle = Callable[[Request, Any], object]
"""Called with a request and its decoded content."""


@record
class ActionQoS:
    """The QoS of an action's three services and two topics."""

    goal: QoS = SERVICES_DEFAULT
    result: QoS = SERVICES_DEFAULT
    cancel: QoS = SERVICES_DEFAULT
    feedback: QoS = DEFAULT
    status: QoS = ACTION_STATUS_DEFAULT


class ActionServerEndpoints:
    """The endpoints of one action server. No request comes before `open`."""

    def __init__(
        self,
        node: NodeCore,
        support: ActionSupport,
        names: ResolvedAction,
        qos: ActionQoS,
        group: CallbackGroup,
    ) -> None:
        self._node = node
        self._support = support
        self.names = names
        self._qos = qos
        self._group = group
        self._declared = ExitStack()
        self.servers: tuple[ActionService, ...] = ()
        """The servers for goals, results and cancelling."""
        self.feedback: PublisherPort
        self.status: PublisherPort

    def open(
        self, on_goal: Handle, on_result: Handle, on_cancel: Handle, split_goal: Callable[[Payload], object]
    ) -> None:
        """Declare the services and topics. If one declaration fails, the earlier ones are taken back."""
        names, support, qos = self.names, self._support, self._qos
        with ExitStack() as undo:
            self.feedback = self._publisher(names.feedback, support.feedback, qos.feedback, patient=True)
            undo.callback(self.feedback.close)
            self.status = self._publisher(names.status, support.status, qos.status)
            undo.callback(self.status.close)
            self.servers = (
                self._server(names.send_goal, support.send_goal, qos.goal, on_goal, split_goal),
                self._server(names.get_result, support.get_result, qos.result, on_result, wire.goal_id_of),
                self._server(
                    names.cancel_goal, support.cancel_goal, qos.cancel, on_cancel, wire.decode_cancel_request
                ),
            )
            self.servers[1].event_queue.is_patient = True
            for server in self.servers:
                undo.callback(server.destroy)
                server.open()
            self._declared = undo.pop_all()

    def take_result_requests(self) -> None:
        """Handle the waiting requests for results on the calling thread, without the executor."""
        _, results, _ = self.servers
        results.work_off()

    def close(self) -> None:
        """Undeclare the services and topics; waiting requests are cancelled."""
        self._declared.close()

    def _server(
        self,
        name: str,
        support: ServiceSupport,
        qos: QoS,
        handle: Handle,
        decode: Callable[[Payload], object],
    ) -> ActionService:
        return ActionService(self._node, support, name, handle, qos, self._group, decode=decode)

    def _publisher(
        self, name: str, support: MessageSupport, qos: QoS, *, patient: bool = False
    ) -> PublisherPort:
        return self._node.port.publisher(
            describe_endpoint(self._node, EndpointKind.PUBLISHER, name, support, qos, waits_for_room=patient)
        )
