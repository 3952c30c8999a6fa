"""Actions that a client serves, with their feedback and results."""

from __future__ import annotations

import asyncio
from itertools import count
from typing import Any

import goalwire
from goalwire.aio.action.server import Goal
from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.rosbridge.client import Client, Operation, text_of
from goalwire.apps.bridge.rosbridge.values import to_json
from goalwire.errors import GoalAborted
from goalwire.records import record
from goalwire.rules.goals.states import GoalStatus

GRACE_S = 10.0
"""Seconds that a client may take to end a goal after a cancel request."""


@record
class _Served:
    cls: Any
    port: goalwire.ActionServer[Any, Any, Any]


class _Running:
    """A goal that the client executes."""

    def __init__(self, action: str, goal: Goal[Any, Any]) -> None:
        self.action = action
        self.goal = goal
        self.end: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

    def abort(self, reason: str) -> None:
        """End the goal without a result."""
        if not self.end.done():
            self.end.set_exception(GoalAborted(reason))


class ServingActions:
    """The actions that one client serves. When the client disconnects, its running goals are aborted."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._actions: dict[str, _Served] = {}
        self._running: dict[str, _Running] = {}
        self._numbers = count(1)
        self.operations = {
            'advertise_action': self.advertise,
            'unadvertise_action': self.unadvertise,
            'action_feedback': self.feed_back,
            'action_result': self.finish,
        }

    async def advertise(self, operation: Operation) -> None:
        """Serve an action by handing each goal to the client."""
        given = text_of(operation, 'action')
        action = full_name(given)
        hub = self._client.hub
        self._client.permissions.check_serve_action(action)
        type_name, cls = await hub.interfaces.find(text_of(operation, 'type'), 'action')
        self._end(action)

        async def execute(goal: Goal[Any, Any]) -> Any:
            return await self._execute(action, given, type_name, goal)

        self._actions[action] = _Served(cls, hub.node.action_server(cls, action, execute))

    async def _execute(self, action: str, given: str, type_name: str, goal: Goal[Any, Any]) -> Any:
        name = f'action_goal:{given}:{next(self._numbers)}'
        running = self._running[name] = _Running(action, goal)
        try:
            self._client.send(
                {
                    'op': 'send_action_goal',
                    'id': name,
                    'action': given,
                    'action_type': type_name,
                    'args': to_json(goal.request),
                    'feedback': True,
                }
            )
            try:
                return await asyncio.shield(running.end)
            except asyncio.CancelledError:  # because the goal is being cancelled, or the bridge ends
                self._client.send({'op': 'cancel_action_goal', 'id': name, 'action': given})
                async with asyncio.timeout(GRACE_S):
                    return await running.end
        finally:
            del self._running[name]

    async def feed_back(self, operation: Operation) -> None:
        """Publish the client's feedback on one of its goals."""
        running = self._find(operation)
        if running is not None:
            cls = self._actions[running.action].cls
            running.goal.feedback(self._client.message(cls.Feedback, operation.get('values')))

    async def finish(self, operation: Operation) -> None:
        """Take the result of a goal; without a status the goal counts as succeeded."""
        running = self._find(operation)
        if running is None or running.end.done():
            return
        if operation.get('result') is False:
            running.abort(str(operation.get('values') or 'its server says that it failed'))
            return
        try:
            result = self._client.message(self._actions[running.action].cls.Result, operation.get('values'))
        except ValueError as error:
            running.abort(f'its server sent a result that does not fit: {error}')
            raise
        status = operation.get('status', GoalStatus.SUCCEEDED)
        if status in {GoalStatus.SUCCEEDED, GoalStatus.CANCELED}:
            running.end.set_result(result)
        else:
            running.end.set_exception(GoalAborted('its server aborted it', result=result))

    def _find(self, operation: Operation) -> _Running | None:
        running = self._running.get(str(operation.get('id')))
        if running is None:
            text = f"{operation['op']}: no goal '{operation.get('id')}' runs"
            self._client.tell('warning', text, operation)
        return running

    async def unadvertise(self, operation: Operation) -> None:
        """Stop serving an action; its goals are aborted."""
        action = full_name(text_of(operation, 'action'))
        if not self._end(action):
            self._client.tell('error', f"unadvertise_action: '{action}' is not advertised", operation)

    def _end(self, action: str) -> bool:
        served = self._actions.pop(action, None)
        if served is None:
            return False
        for running in list(self._running.values()):
            if running.action == action:
                running.abort('its server serves the action no longer')
        served.port.close()
        return True

    def close(self) -> None:
        """End every action."""
        for action in list(self._actions):
            self._end(action)
