"""The services for a client, including send_goal, cancel_goal and get_result of actions.

The bridge remembers goals that a client sends by such a service. If the client is lost before it has the
result, the goal is cancelled.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from itertools import count
from typing import Any

from goalwire.apps.bridge.foxglove import frames
from goalwire.apps.bridge.foxglove.client import Client
from goalwire.apps.bridge.foxglove.type_requests import TypeRequests
from goalwire.cdr import codec
from goalwire.errors import GoalwireError, UnknownInterfaceError
from goalwire.observe.goal_topics import cancel_request
from goalwire.observe.messages import interface_class
from goalwire.records import record
from goalwire.rosbag2.definitions import schema_of

_SEND, _RESULT, _CANCEL = '/_action/send_goal', '/_action/get_result', '/_action/cancel_goal'
_CANCEL_S = 5.0
"""Seconds that an action server may take to answer the cancel request for a lost client's goal."""


@record
class Shown:
    """A service that the client is shown, with one of its types."""

    name: str
    type_name: str


class Services:
    """The services that a client is shown, and its calls."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._numbers = count(1)
        self._services: dict[Shown, int] = {}
        self._requests = TypeRequests(client, self.update)
        self._goals: dict[tuple[str, bytes], asyncio.Task[Any]] = {}
        """By action and goal id: the send_goal calls of goals whose result the client does not have yet.

        Each call runs until the server answers, even if the client is lost first, because only an accepted
        goal may be cancelled: a refused goal may have the id of another client's goal.
        """

    def update(self) -> None:
        """Send the client the new and the removed services."""
        permissions = self._client.permissions
        there = {
            Shown(name, type_name)
            for name, types in self._client.hub.node.graph.served()
            if permissions.shows_service(name) and not permissions.read_only
            for type_name in types
        }
        gone = [each for each in self._services if each not in there]
        if gone:
            self._client.send('unadvertiseServices', serviceIds=[self._services.pop(each) for each in gone])
        new = [self._description(each) for each in there if each not in self._services]
        if shown := [each for each in new if each]:
            self._client.send('advertiseServices', services=shown)

    def _description(self, service: Shown) -> dict[str, Any] | None:
        parts: dict[str, Any] = {}
        for part, name in (('request', 'Request'), ('response', 'Response')):
            schema, _ = schema_of(f'{service.type_name}_{name}')
            if not schema.encoding:
                self._requests.ask_for(service.type_name)
                return None
            parts[part] = {
                'encoding': frames.ENCODING,
                'schemaName': f'{service.type_name}_{name}',
                'schemaEncoding': schema.encoding,
                'schema': schema.text,
            }
            parts[f'{part}Schema'] = schema.text  # for clients of the protocol's first version
        number = self._services[service] = next(self._numbers)
        return {'id': number, 'name': service.name, 'type': service.type_name, **parts}

    def call(self, request: frames.ServiceRequest) -> None:
        """Begin a call."""
        self._client.start(self._answer(request))

    async def _answer(self, request: frames.ServiceRequest) -> None:
        try:
            data = await self._response(request)
        except (GoalwireError, ValueError) as error:
            self._client.send(
                'serviceCallFailure', serviceId=request.service, callId=request.call, message=str(error)
            )
        else:
            self._client.outbox.put([frames.response(request.service, request.call, data)])

    async def _response(self, request: frames.ServiceRequest) -> bytes:
        service = next((each for each, number in self._services.items() if number == request.service), None)
        if service is None:
            raise UnknownInterfaceError(f'there is no service {request.service}')
        if request.encoding != frames.ENCODING:
            raise UnknownInterfaceError(f"the encoding must be '{frames.ENCODING}', not '{request.encoding}'")
        self._client.permissions.check_call(service.name)
        cls = interface_class(service.type_name)
        message = codec.decode(request.data, cls.Request)
        if service.name.endswith(_SEND):
            response = await self._send_goal(service, cls, message)
        else:
            response = await self._call(service, cls, message)
        if service.name.endswith(_RESULT):
            self._goals.pop(_goal_of(service, message), None)
        return codec.encode(response)

    async def _call(self, service: Shown, cls: Any, message: Any) -> Any:
        hub = self._client.hub
        limit = None if service.name.endswith(_RESULT) else hub.settings.call_timeout
        with hub.services.borrow(
            service.name, service.type_name, lambda: hub.node.client(cls, service.name)
        ) as client:
            return await client.call(message, timeout=limit)

    async def _send_goal(self, service: Shown, cls: Any, message: Any) -> Any:
        """Send a goal; note the goal first, because the client may be lost before the server answers."""
        goal = _goal_of(service, message)
        call = asyncio.create_task(self._call(service, cls, message))
        # Reading the exception keeps asyncio from reporting it as never retrieved.
        call.add_done_callback(lambda done: done.cancelled() or done.exception())
        if goal not in self._goals:
            self._goals[goal] = call
        response = await asyncio.shield(call)
        if not response.accepted and self._goals.get(goal) is call:
            del self._goals[goal]
        return response

    async def cancel_goals(self) -> None:
        """Cancel the goals of the lost client."""
        await asyncio.gather(*(self._cancel(*goal, call) for goal, call in self._goals.items()))
        self._goals.clear()

    async def _cancel(self, action: str, goal_id: bytes, sending: asyncio.Task[Any]) -> None:
        """Cancel a goal unless its server refused it; in doubt cancel it, because a robot may be moving."""
        from action_msgs.srv import CancelGoal

        with suppress(GoalwireError):
            if not (await sending).accepted:
                return
        node = self._client.hub.node
        client = node.client(CancelGoal, f'{action}{_CANCEL}')
        try:
            await client.call(cancel_request(goal_id.hex()), timeout=_CANCEL_S)
        except GoalwireError as error:
            node.logger.warning(f'a goal of a lost client was not cancelled: {error}')
        finally:
            client.close()


def _goal_of(service: Shown, message: Any) -> tuple[str, bytes]:
    """Return the action and the id of the goal that a request is about."""
    return service.name.removesuffix(_SEND).removesuffix(_RESULT), bytes(message.goal_id.uuid)
