"""The parameters of nodes, with the names '/node.parameter' as in foxglove_bridge."""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import ParameterEvent

from goalwire.apps.bridge.foxglove.client import Client, Fields, objects_of, texts_of
from goalwire.apps.bridge.topic_feeds import Arrival
from goalwire.errors import CallError
from goalwire.observe.parameters import NodeParameters, nodes_with_parameters
from goalwire.rules.parameters.messages import value_of
from goalwire.rules.parameters.parameter import Parameter

_ANSWER_S = 2.0
"""How long a node may take to answer."""


class Parameters:
    """The parameters that a client reads, sets and follows."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._followed: set[str] = set()
        self._stop: Callable[[], None] | None = None

    async def get(self, fields: Fields) -> None:
        """Begin to read parameters: the named ones, or all."""
        self._client.start(self._get(texts_of(fields, 'parameterNames'), fields.get('id')))

    async def _get(self, names: list[str], request: object) -> None:
        found: list[dict[str, Any]] = []
        for node, wanted in self._by_node(names).items():
            try:
                with NodeParameters(self._client.hub.node, node, _ANSWER_S) as parameters:
                    values = await parameters.values(wanted or await parameters.names())
            except CallError:
                continue  # The node has left the graph.
            found += [
                _show(f'{node}.{name}', value) for name, value in values.items() if self._allows(node, name)
            ]
        about = {} if request is None else {'id': request}
        self._client.send('parameterValues', parameters=found, **about)

    def _allows(self, node: str, name: str) -> bool:
        return self._client.permissions.shows_parameter(f'{node}:{name}')

    def _by_node(self, names: Iterable[str]) -> dict[str, list[str]]:
        """Group parameter names by node. Without names, return every node, each with an empty list."""
        nodes = nodes_with_parameters(self._client.hub.node.graph.served())
        found: dict[str, list[str]] = {} if names else {node: [] for node in nodes}
        for full in names:
            node, _, name = full.partition('.')
            if node in nodes and name:
                found.setdefault(node, []).append(name)
        return found

    async def set(self, fields: Fields) -> None:
        """Begin to set parameters; if the request has an id, send the new values afterwards."""
        self._client.start(self._set(objects_of(fields, 'parameters'), fields.get('id')))

    async def _set(self, parameters: list[Fields], request: object) -> None:
        names = [str(each.get('name')) for each in parameters]
        for each, full in zip(parameters, names, strict=True):
            node, _, name = full.partition('.')
            try:
                self._client.permissions.check_parameter(f'{node}:{name}', to_set=True)
                message = Parameter(name, value=_value(each)).get_parameter_value()
                with NodeParameters(self._client.hub.node, node, _ANSWER_S) as node_parameters:
                    ((_, result),) = await node_parameters.set([(name, message)])
                if not result.successful:
                    self._client.tell(f"'{full}' was not set: {result.reason or 'its node gives no reason'}")
            except Exception as error:  # Report any error, of a node or of a value, to the client.
                self._client.tell(f"'{full}' was not set: {error}")
        if request is not None:
            await self._get(names, request)

    async def follow(self, fields: Fields) -> None:
        """Tell the client of changes of parameters from now on."""
        self._followed |= set(texts_of(fields, 'parameterNames'))
        if self._stop is None:
            feeds = self._client.hub.feeds
            type_name = 'rcl_interfaces/msg/ParameterEvent'
            self._stop = feeds.listen('/parameter_events', type_name, ParameterEvent, self)

    async def unfollow(self, fields: Fields) -> None:
        """Stop following some parameters."""
        self._followed -= set(texts_of(fields, 'parameterNames'))

    def take(self, arrival: Arrival) -> None:
        """Send changed parameters to the client."""
        event = arrival.message
        changed = [
            _show(f'{event.node}.{each.name}', each.value)
            for each in (*event.new_parameters, *event.changed_parameters)
            if f'{event.node}.{each.name}' in self._followed and self._allows(event.node, each.name)
        ]
        if changed:
            self._client.send('parameterValues', parameters=changed)

    def close(self) -> None:
        """Stop following parameters."""
        if self._stop is not None:
            self._stop()


def _show(name: str, message: Any) -> dict[str, Any]:
    value = value_of(message)
    if isinstance(value, list) and value and isinstance(value[0], bytes):
        return {'name': name, 'type': 'byte_array', 'value': b64encode(b''.join(value)).decode('ascii')}
    shown: dict[str, Any] = {'name': name, 'value': value}
    if isinstance(value, float):
        shown['type'] = 'float64'
    elif isinstance(value, list) and value and isinstance(value[0], float):
        shown['type'] = 'float64_array'
    return shown


def _value(given: Fields) -> Any:
    value, kind = given.get('value'), given.get('type')
    if kind == 'byte_array' and isinstance(value, str):
        return [bytes((each,)) for each in b64decode(value)]
    if kind == 'float64' and isinstance(value, int):
        return float(value)
    if kind == 'float64_array' and isinstance(value, list):
        return [float(each) for each in value]
    return value
