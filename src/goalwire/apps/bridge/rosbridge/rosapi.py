"""The services of rosapi, which the bridge answers itself: the graph, types and parameters.

They are not in the graph. So two bridges do not conflict, and a client sees only names that it may use. The
services' names and fields are those of rosapi_msgs.
"""

from __future__ import annotations

import os
from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Any

from goalwire.apps.bridge.hub import Hub, full_name
from goalwire.apps.bridge.interfaces import full_type_name
from goalwire.apps.bridge.permissions import Permissions
from goalwire.apps.bridge.rosbridge.rosapi_parameters import ParameterServices
from goalwire.apps.bridge.rosbridge.typedefs import typedefs
from goalwire.errors import FieldValueError
from goalwire.graph.names import NamesAndTypes, is_part_of_action
from goalwire.rosbag2.definitions import schema_of
from goalwire.rules.names.validation import is_hidden_name
from goalwire.transport.contract import EndpointKind, GraphEntity

PREFIX = '/rosapi/'
_DISTRO = 'jazzy'
"""The answer if ROS_DISTRO is not set: the release of goalwire's interfaces."""
Fields = Mapping[str, Any]
Handler = Callable[[Fields], Awaitable[dict[str, Any]]]


class RosApi:
    """Answers calls of `/rosapi/…`."""

    def __init__(self, hub: Hub, permissions: Permissions) -> None:
        self._hub = hub
        self._permissions = permissions
        parameters = ParameterServices(hub, permissions)
        self._services: dict[str, tuple[Handler, tuple[str, ...]]] = {
            'topics': (self._topics, ()),
            'topics_for_type': (self._topics_for_type, ('type',)),
            'topics_and_raw_types': (self._raw_types, ()),
            'topic_type': (self._topic_type, ('topic',)),
            'publishers': (self._publishers, ('topic',)),
            'subscribers': (self._subscribers, ('topic',)),
            'services': (self._services_there, ()),
            'services_for_type': (self._services_for_type, ('type',)),
            'service_type': (self._service_type, ('service',)),
            'service_providers': (self._providers, ('service',)),
            'service_node': (self._service_node, ('service',)),
            'action_servers': (self._action_servers, ()),
            'nodes': (self._nodes, ()),
            'node_details': (self._node_details, ('node',)),
            'message_details': (self._message_details, ('type',)),
            'service_request_details': (self._request_details, ('type',)),
            'service_response_details': (self._response_details, ('type',)),
            'get_time': (self._time, ()),
            'get_ros_version': (self._version, ()),
            'get_param': (parameters.get, ('name', 'default_value')),
            'set_param': (parameters.set, ('name', 'value')),
            'has_param': (parameters.has, ('name',)),
            'delete_param': (parameters.delete, ('name',)),
            'get_param_names': (parameters.names, ()),
        }

    def has(self, service: str) -> bool:
        """Return True if a service, given by its full name, is one of rosapi's."""
        return service.removeprefix(PREFIX) in self._services and service.startswith(PREFIX)

    async def call(self, service: str, args: object) -> dict[str, Any]:
        """Return the response. Raises GoalwireError, FieldValueError for arguments that do not fit."""
        handler, names = self._services[service.removeprefix(PREFIX)]
        if isinstance(args, list):
            args = dict(zip(names, args, strict=False))
        given = args if isinstance(args, Mapping) else {}
        for name in names:
            if not isinstance(given.get(name, ''), str):
                raise FieldValueError(name, 'give a text', 'string')
        return await handler({name: given.get(name, '') for name in names})

    # -- topics ----------------------------------------------------------------------------------------------

    def _list_topics(self) -> NamesAndTypes:
        return [
            (name, types)
            for name, types in self._hub.node.graph.topics()
            if not is_hidden_name(name) and self._permissions.shows_topic(name)
        ]

    async def _topics(self, _args: Fields) -> dict[str, Any]:
        topics = self._list_topics()
        return {'topics': [name for name, _ in topics], 'types': [types[0] for _, types in topics]}

    async def _topics_for_type(self, args: Fields) -> dict[str, Any]:
        return {'topics': _of_type(self._list_topics(), full_type_name(args['type'], 'msg'))}

    async def _raw_types(self, args: Fields) -> dict[str, Any]:
        answer = await self._topics(args)
        texts = [schema_of(type_name)[0].text for type_name in answer['types']]
        return answer | {'typedefs_full_text': texts}

    async def _topic_type(self, args: Fields) -> dict[str, Any]:
        return {'type': dict(self._list_topics()).get(full_name(args['topic']), [''])[0]}

    async def _publishers(self, args: Fields) -> dict[str, Any]:
        return {'publishers': self._nodes_of(EndpointKind.PUBLISHER, args['topic'])}

    async def _subscribers(self, args: Fields) -> dict[str, Any]:
        return {'subscribers': self._nodes_of(EndpointKind.SUBSCRIPTION, args['topic'])}

    def _nodes_of(self, kind: EndpointKind, name: str) -> list[str]:
        full = full_name(name)
        is_seen = (
            self._permissions.shows_service if kind is EndpointKind.SERVICE else self._permissions.shows_topic
        )
        return _nodes(each for each in self._endpoints(kind) if each.name == full) if is_seen(full) else []

    def _endpoints(self, kind: EndpointKind) -> list[GraphEntity]:
        return [each for each in self._hub.node.graph.endpoints() if each.kind is kind]

    # -- services and actions --------------------------------------------------------------------------------

    def _list_services(self) -> NamesAndTypes:
        return [
            (name, types)
            for name, types in self._hub.node.graph.served()
            if not is_part_of_action(name) and self._permissions.shows_service(name)
        ]

    async def _services_there(self, _args: Fields) -> dict[str, Any]:
        return {'services': [name for name, _ in self._list_services()]}

    async def _services_for_type(self, args: Fields) -> dict[str, Any]:
        return {'services': _of_type(self._list_services(), full_type_name(args['type'], 'srv'))}

    async def _service_type(self, args: Fields) -> dict[str, Any]:
        return {'type': dict(self._list_services()).get(full_name(args['service']), [''])[0]}

    async def _providers(self, args: Fields) -> dict[str, Any]:
        return {'providers': self._nodes_of(EndpointKind.SERVICE, args['service'])}

    async def _service_node(self, args: Fields) -> dict[str, Any]:
        return {'node': next(iter(self._nodes_of(EndpointKind.SERVICE, args['service'])), '')}

    async def _action_servers(self, _args: Fields) -> dict[str, Any]:
        end = '/_action/send_goal'
        served = (name.removesuffix(end) for name, _ in self._hub.node.graph.served() if name.endswith(end))
        return {'action_servers': [name for name in served if self._permissions.shows_action(name)]}

    # -- nodes and types -------------------------------------------------------------------------------------

    async def _nodes(self, _args: Fields) -> dict[str, Any]:
        return {
            'nodes': [each for each in self._hub.node.graph.nodes() if self._permissions.shows_node(each)]
        }

    async def _node_details(self, args: Fields) -> dict[str, Any]:
        node = full_name(args['node'])

        def of_node(kind: EndpointKind, is_seen: Callable[[str], bool]) -> list[str]:
            names = {each.name for each in self._endpoints(kind) if each.node.qualified == node}
            return sorted(name for name in names if not is_hidden_name(name) and is_seen(name))

        return {
            'subscribing': of_node(EndpointKind.SUBSCRIPTION, self._permissions.shows_topic),
            'publishing': of_node(EndpointKind.PUBLISHER, self._permissions.shows_topic),
            'services': of_node(EndpointKind.SERVICE, self._permissions.shows_service),
        }

    async def _message_details(self, args: Fields) -> dict[str, Any]:
        _, cls = await self._hub.interfaces.find(args['type'], 'msg')
        return {'typedefs': typedefs(cls)}

    async def _request_details(self, args: Fields) -> dict[str, Any]:
        _, cls = await self._hub.interfaces.find(args['type'], 'srv')
        return {'typedefs': typedefs(cls.Request)}

    async def _response_details(self, args: Fields) -> dict[str, Any]:
        _, cls = await self._hub.interfaces.find(args['type'], 'srv')
        return {'typedefs': typedefs(cls.Response)}

    async def _time(self, _args: Fields) -> dict[str, Any]:
        seconds, nanoseconds = self._hub.node.clock.now().seconds_nanoseconds()
        of_ros_1 = {'secs': seconds, 'nsecs': nanoseconds}  # roslibpy reads these two fields
        return {'time': {'sec': seconds, 'nanosec': nanoseconds, **of_ros_1}}

    async def _version(self, _args: Fields) -> dict[str, Any]:
        return {'version': 2, 'distro': os.environ.get('ROS_DISTRO', _DISTRO)}


def _of_type(names: NamesAndTypes, type_name: str) -> list[str]:
    return [name for name, types in names if type_name in types]


def _nodes(entities: Iterable[GraphEntity]) -> list[str]:
    return sorted({each.node.qualified for each in entities})
