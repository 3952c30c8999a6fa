"""The two streams that an action client reads: the feedback and the statuses of goals."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import ReferenceType, ref

from goalwire.entities.actions.client_goal_handle import GoalFeedback
from goalwire.entities.endpoint import describe_endpoint
from goalwire.errors import RemoteError
from goalwire.execution.callback_arguments import advise_callback
from goalwire.execution.event_queue import EventQueue
from goalwire.fault_reports import log_rejected
from goalwire.rules.goals.states import GoalStatus
from goalwire.rules.goals.status_array import statuses_of
from goalwire.transport.contract import EndpointKind, Sample

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.client_goal_handle import ResultFuture
    from goalwire.entities.actions.client_requests import ActionSide
    from goalwire.entities.actions.endpoints import ActionQoS
    from goalwire.entities.names import ResolvedAction
    from goalwire.entities.type_support import ActionSupport, MessageSupport
    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.rules.goals.client import GoalClient
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Payload, Port

_STATUS_LIMIT = 10
"""How many status arrays may wait. One is too few: the end of a goal whose result is not kept appears in a
single array.
"""


class ClientStreams:
    """The subscriptions of one action client.

    Their messages go through the executor, in the client's group.
    """

    def __init__(
        self,
        action: ActionSide,
        support: ActionSupport,
        group: CallbackGroup,
        goals: GoalClient[ResultFuture, Payload],
        take_statuses: Callable[[bytes], object],
    ) -> None:
        """`take_statuses` gets each status array; it raises RemoteError for one that it cannot read."""
        self._action = action
        self._support = support
        self._group = group
        self._goals = goals
        self._take_statuses = take_statuses
        self.feedback = 0
        """How many feedback messages have come for goals of this client."""
        self.latest_statuses = b''
        """The status array that came last; b'' before the first."""
        self._feedback_rejected = 0
        self._statuses_rejected = 0
        self.statuses: EventQueue[Sample] = EventQueue(
            action.node.work_queue, group, self._on_statuses, depth=_STATUS_LIMIT
        )
        self._ports: list[Port] = []

    def open(self, names: ResolvedAction, qos: ActionQoS) -> None:
        """Subscribe to both topics. If the second subscription fails, `close` undoes the first."""
        deliver = partial(ClientStreams._deliver_feedback, ref(self))
        self._subscribe(names.feedback, self._support.feedback, qos.feedback, deliver)
        self._subscribe(names.status, self._support.status, qos.status, self.statuses.deliver)

    def _subscribe(
        self, name: str, support: MessageSupport, qos: QoS, deliver: Callable[[Sample], None]
    ) -> None:
        node = self._action.node
        endpoint = describe_endpoint(node, EndpointKind.SUBSCRIPTION, name, support, qos)
        self._ports.append(node.port.subscription(endpoint, deliver))

    @property
    def rejected(self) -> int:
        """How many messages of either stream could not be decoded."""
        return self._feedback_rejected + self._statuses_rejected

    def published_status(self, goal_id: GoalId) -> GoalStatus:
        """Return a goal's status in the array that came last, whoever sent the goal; UNKNOWN if the goal is
        not in it.
        """
        found = statuses_of([goal_id], self.latest_statuses) if self.latest_statuses else []
        return found[0][1] if found else GoalStatus.UNKNOWN

    def catch_up(self) -> None:
        """Read the feedback that the transport has received and not delivered yet."""
        self._ports[0].catch_up()

    def close(self) -> None:
        """Unsubscribe, and forget the waiting messages."""
        for port in self._ports:
            port.close()
        self.statuses.close()

    def make_feedback_queue(self, callback: Callable[[Any], object]) -> GoalFeedback:
        """Return the queue that decodes one goal's feedback for the program's callback."""
        action = self._action
        what = f"the feedback callback of the action '{action.name}'"
        advise_callback(callback, ('feedback_message',), what, action.logger)
        decode = self._support.feedback.decode

        def handle(sample: Sample) -> object:
            try:
                message = decode(sample.payload)
            except RemoteError as error:
                self.reject_feedback(error)
                return None
            return callback(message)

        return GoalFeedback(action.node.work_queue, self._group, handle, action)

    @staticmethod
    def _deliver_feedback(reference: ReferenceType[ClientStreams], sample: Sample) -> None:
        # hot path: a static method with a weak reference, so that the wire neither keeps the client alive nor
        # makes two calls.
        self = reference()
        if self is None:
            return
        goal_id = bytes(sample.payload[4:20])
        goals = self._goals
        goal = goals.active.get(goal_id) or goals.ended.get(goal_id)  # `find` written out: saves a call
        if goal is None:
            return
        self.feedback += 1
        if goal.heard is not None:
            goal.heard()
        if goal.feedback is not None:
            goal.feedback.deliver(sample)

    def reject_feedback(self, error: RemoteError) -> None:
        """Count a feedback message that cannot be decoded."""
        self._feedback_rejected += 1
        self._log_rejected('feedback', self._feedback_rejected, error)

    def _on_statuses(self, sample: Sample) -> None:
        try:
            payload = bytes(sample.payload)
            self._take_statuses(payload)
            self.latest_statuses = payload
        except RemoteError as error:
            self._statuses_rejected += 1
            self._log_rejected('status', self._statuses_rejected, error)

    def _log_rejected(self, kind: str, count: int, error: RemoteError) -> None:
        what = f"Action '{self._action.name}': a {kind} message was rejected"
        log_rejected(self._action.logger.name, what, count, error, is_error=True)
