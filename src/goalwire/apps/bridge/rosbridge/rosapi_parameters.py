"""rosapi's services for parameters, which are named 'node:parameter'; values travel as JSON in a text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import ParameterValue

from goalwire.apps.bridge.hub import Hub, full_name
from goalwire.apps.bridge.permissions import Permissions
from goalwire.errors import CallError, FieldValueError, NotAllowedError
from goalwire.observe.parameters import NodeParameters, nodes_with_parameters, plain_value
from goalwire.rules.parameters.parameter import Parameter

_ANSWER_S = 2.0
"""How long a node may take to answer."""
Fields = Mapping[str, Any]


class ParameterServices:
    """Reads and sets parameters for clients. As in rosapi, reading a missing parameter succeeds."""

    def __init__(self, hub: Hub, permissions: Permissions) -> None:
        self._hub = hub
        self._permissions = permissions

    async def get(self, args: Fields) -> dict[str, Any]:
        """Return the value as JSON; for a missing parameter return the default, which may be any text."""
        node, name = _split(args['name'])
        self._permissions.check_parameter(f'{node}:{name}', to_set=False)
        value = await self._value(node, name)
        return {'value': _default(args['default_value']) if value is None else json.dumps(plain_value(value))}

    async def has(self, args: Fields) -> dict[str, Any]:
        """Return whether the parameter has a value."""
        node, name = _split(args['name'])
        self._permissions.check_parameter(f'{node}:{name}', to_set=False)
        return {'exists': await self._value(node, name) is not None}

    async def set(self, args: Fields) -> dict[str, Any]:
        """Set a parameter. Raises FieldValueError for a value that is not JSON or that its node refuses."""
        node, name = _split(args['name'])
        try:
            value = json.loads(args['value'])
        except ValueError:
            raise FieldValueError('value', f'give JSON, not {args["value"][:60]}') from None
        await self._set(node, name, value)
        return {}

    async def delete(self, args: Fields) -> dict[str, Any]:
        """Undeclare a parameter, if its node allows that."""
        node, name = _split(args['name'])
        await self._set(node, name, None)
        return {}

    async def names(self, _args: Fields) -> dict[str, Any]:
        """Return the names of all parameters by node, without nodes that do not answer."""
        found: list[str] = []
        for node in nodes_with_parameters(self._hub.node.graph.served()):
            try:
                names = await self._names(node)
            except CallError:
                continue
            allows = self._permissions.shows_parameter
            found += [full for name in names if allows(full := f'{node}:{name}')]
        return {'names': found}

    async def _names(self, node: str) -> list[str]:
        with NodeParameters(self._hub.node, node, _ANSWER_S) as parameters:
            return await parameters.names()

    async def _value(self, node: str, name: str) -> Any:
        with NodeParameters(self._hub.node, node, _ANSWER_S) as parameters:
            try:
                return (await parameters.values([name])).get(name)
            except CallError:
                return None

    async def _set(self, node: str, name: str, value: Any) -> None:
        self._permissions.check_parameter(f'{node}:{name}', to_set=True)
        message = ParameterValue() if value is None else Parameter(name, value=value).get_parameter_value()
        with NodeParameters(self._hub.node, node, _ANSWER_S) as parameters:
            ((_, result),) = await parameters.set([(name, message)])
        if not result.successful:
            raise NotAllowedError(f"'{node}' did not set '{name}': {result.reason or 'it gives no reason'}")


def _split(text: str) -> tuple[str, str]:
    """Return node and parameter. Raises FieldValueError."""
    node, colon, name = text.partition(':')
    if not (node and colon and name):
        raise FieldValueError('name', f"write node:parameter, not '{text[:60]}'")
    return full_name(node), name


def _default(text: str) -> str:
    try:
        json.loads(text)
    except ValueError:
        return json.dumps(text)
    return text
