"""send_action_goal and cancel_action_goal: goals of one client, each followed until its end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatusArray

from goalwire.apps.bridge.goals import GoalEnd, SentGoal
from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.rosbridge.client import BadOperationError, Client, Operation, text_of, with_id
from goalwire.apps.bridge.rosbridge.values import to_json
from goalwire.apps.bridge.topic_feeds import Arrival
from goalwire.errors import GoalwireError
from goalwire.rules.goals.states import GoalStatus


class SendingGoals:
    """The goals that one client has sent, by the ids that the client gave them."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._goals: dict[object, SentGoal] = {}
        self.operations = {'send_action_goal': self.send, 'cancel_action_goal': self.cancel}

    async def send(self, operation: Operation) -> None:
        """Send a goal; `action_result` reports its end."""
        text_of(operation, 'action')
        if operation.get('id') is not None and operation['id'] in self._goals:
            raise BadOperationError(f"send_action_goal: the id '{operation['id']}' belongs to a running goal")
        outlives = self._client.hub.settings.keeps_goals
        self._client.start(self._follow(operation), outlives=outlives)

    async def _follow(self, operation: Operation) -> None:
        given = text_of(operation, 'action')
        try:
            end = await self._run(full_name(given), operation)
        except (GoalwireError, ValueError) as error:
            end = GoalEnd(GoalStatus.UNKNOWN, problem=str(error))
        answer: dict[str, Any] = {'op': 'action_result', 'action': given, 'status': int(end.status)}
        if end.result is None:
            answer |= {'values': end.problem, 'result': False}
            self._client.tell('error', f'send_action_goal: {given}: {end.problem}', operation)
        else:
            answer |= {'values': to_json(end.result), 'result': True}
        self._client.send(with_id(answer, operation), operation)

    async def _run(self, action: str, operation: Operation) -> GoalEnd:
        hub = self._client.hub
        self._client.permissions.check_goal(action)
        type_name, cls = await hub.interfaces.find(text_of(operation, 'action_type'), 'action')
        goal = self._client.message(cls.Goal, operation.get('args'))
        with hub.actions.borrow(action, type_name, lambda: hub.node.action(cls, action)) as client:
            reports = _Reports(self._client, action, operation)
            sent = SentGoal(client, goal, reports, hub.settings.call_timeout)
            name = operation.get('id')
            if name is not None:
                self._goals[name] = sent
            try:
                end = await sent.follow()
            finally:
                reports.close()
                if name is not None:
                    del self._goals[name]
        reports.tell(int(end.status))
        return end

    async def cancel(self, operation: Operation) -> None:
        """Request the cancellation of a running goal; `action_result` reports its end."""
        sent = self._goals.get(operation.get('id'))
        if sent is None:
            text = f"cancel_action_goal: no goal '{operation.get('id')}' of this client runs"
            self._client.tell('error', text, operation)
            return
        self._client.start(self._cancel(sent, operation))

    async def _cancel(self, sent: SentGoal, operation: Operation) -> None:
        try:
            if not await sent.cancel():
                self._client.tell(
                    'error', 'cancel_action_goal: the server does not cancel the goal', operation
                )
        except GoalwireError as error:
            self._client.tell('error', f'cancel_action_goal: {error}', operation)

    def close(self) -> None:
        """Do nothing here: a client that disconnects cancels the tasks of its goals, unless the bridge was
        started to keep the goals.
        """


class _Reports:
    """Sends a client the feedback and status of one of its goals, if the client has requested them."""

    def __init__(self, client: Client, action: str, operation: Operation) -> None:
        self._client = client
        self._action = action
        self._operation = operation
        self._goal_id = b''
        self._status = 0
        self._stop: Callable[[], None] = lambda: None

    def on_accepted(self, goal_id: bytes) -> None:
        self._goal_id = goal_id
        if self._operation.get('status') is True:
            self._stop = self._client.hub.feeds.listen(
                f'{self._action}/_action/status', 'action_msgs/msg/GoalStatusArray', GoalStatusArray, self
            )

    def on_feedback(self, feedback: Any) -> None:
        if self._operation.get('feedback'):
            self._send('action_feedback', {'values': to_json(feedback)})

    def take(self, arrival: Arrival) -> None:
        """Take the statuses of all goals of the action."""
        for each in arrival.message.status_list:
            if bytes(each.goal_info.goal_id.uuid) == self._goal_id:
                self.tell(each.status)

    def tell(self, status: int) -> None:
        """Send the client a new status.

        The status topic keeps only its last message, so CANCELING may be missed. Because CANCELED always
        follows CANCELING, a missed CANCELING is sent first.
        """
        if self._operation.get('status') is not True or status == self._status:
            return
        if status == GoalStatus.CANCELED and self._status != GoalStatus.CANCELING:
            self.tell(int(GoalStatus.CANCELING))
        self._status = status
        self._send('action_status', {'status': status})

    def _send(self, op: str, fields: dict[str, Any]) -> None:
        message = {'op': op, 'action': self._operation['action'], **fields}
        self._client.send(with_id(message, self._operation), self._operation)

    def close(self) -> None:
        """Stop listening to statuses."""
        self._stop()
