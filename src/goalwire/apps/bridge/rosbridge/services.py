"""Services: the calls of a client, and the services that it serves."""

from __future__ import annotations

import asyncio
from itertools import count
from typing import Any

import goalwire
from goalwire.apps.bridge.hub import full_name
from goalwire.apps.bridge.rosbridge.client import Client, Operation, number_of, text_of, with_id
from goalwire.apps.bridge.rosbridge.rosapi import RosApi
from goalwire.apps.bridge.rosbridge.values import to_json
from goalwire.errors import GoalwireError, ServerLostError
from goalwire.records import record


class Calling:
    """The calls of one client. The bridge itself answers calls of rosapi's services."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._api = RosApi(client.hub, client.permissions)
        self.operations = {'call_service': self.call}

    async def call(self, operation: Operation) -> None:
        """Begin a call; `service_response` reports its end."""
        given = text_of(operation, 'service')
        self._client.start(self._answer(given, operation))

    async def _answer(self, given: str, operation: Operation) -> None:
        answer: dict[str, Any] = {'op': 'service_response', 'service': given}
        try:
            values = await self._values(given, operation)
        except (GoalwireError, ValueError) as error:
            answer |= {'values': str(error), 'result': False}
            self._client.tell('error', f'call_service: {given}: {error}', operation)
        else:
            answer |= {'values': values, 'result': True}
        self._client.send(with_id(answer, operation), operation)

    async def _values(self, given: str, operation: Operation) -> Any:
        service = full_name(given)
        if self._api.has(service):
            return await self._api.call(service, operation.get('args'))
        hub = self._client.hub
        self._client.permissions.check_call(service)
        limit = number_of(operation, 'timeout') or hub.settings.call_timeout
        type_name, cls = await hub.interfaces.find(await hub.type_of_service(service), 'srv')
        request = self._client.message(cls.Request, operation.get('args'))
        with hub.services.borrow(service, type_name, lambda: hub.node.client(cls, service)) as client:
            return to_json(await client.call(request, timeout=limit))

    def close(self) -> None:
        """Do nothing: the calls are tasks of the client, which cancels them."""


@record
class _Served:
    type_name: str
    cls: Any
    port: goalwire.Service[Any, Any]


class ServingServices:
    """The services that one client serves; they end when it disconnects."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._services: dict[str, _Served] = {}
        self._waiting: dict[str, tuple[str, asyncio.Future[Any]]] = {}
        """By id: the service and the pending response of each request that the client has not answered."""
        self._numbers = count(1)
        self.operations = {
            'advertise_service': self.advertise,
            'unadvertise_service': self.unadvertise,
            'service_response': self.respond,
        }

    async def advertise(self, operation: Operation) -> None:
        """Serve a service; its requests are sent to the client."""
        given = text_of(operation, 'service')
        service = full_name(given)
        hub = self._client.hub
        self._client.permissions.check_serve(service)
        type_name, cls = await hub.interfaces.find(text_of(operation, 'type'), 'srv')
        self._end(service)

        async def ask(request: Any) -> Any:
            return await self._ask(service, given, request)

        self._services[service] = _Served(type_name, cls, hub.node.service(cls, service, ask))

    async def _ask(self, service: str, given: str, request: Any) -> Any:
        name = f'service_request:{given}:{next(self._numbers)}'
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiting[name] = service, answer
        try:
            self._client.send({'op': 'call_service', 'id': name, 'service': given, 'args': to_json(request)})
            return await answer
        finally:
            del self._waiting[name]

    async def respond(self, operation: Operation) -> None:
        """Take the client's response to a request."""
        service, answer = self._waiting.get(str(operation.get('id')), ('', None))
        if answer is None or answer.done():
            text = f"service_response: there is no request '{operation.get('id')}'"
            self._client.tell('warning', text, operation)
            return
        if operation.get('result') is False:
            problem = str(operation.get('values') or 'its client says that it failed')
            answer.set_exception(ServerLostError(problem))
            return
        try:
            response = self._client.message(self._services[service].cls.Response, operation.get('values'))
        except ValueError as error:
            answer.set_exception(ServerLostError(f'its client sent a response that does not fit: {error}'))
            raise
        answer.set_result(response)

    async def unadvertise(self, operation: Operation) -> None:
        """Stop serving a service."""
        service = full_name(text_of(operation, 'service'))
        if not self._end(service):
            self._client.tell('error', f"unadvertise_service: '{service}' is not advertised", operation)

    def _end(self, service: str) -> bool:
        served = self._services.pop(service, None)
        if served is None:
            return False
        for name, answer in list(self._waiting.values()):
            if name == service and not answer.done():
                answer.set_exception(ServerLostError('its client serves it no longer'))
        served.port.close()
        return True

    def close(self) -> None:
        """End every service."""
        for service in list(self._services):
            self._end(service)
