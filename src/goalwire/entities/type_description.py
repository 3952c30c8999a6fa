"""~/get_type_description: a node describes the types that it uses (rcl's type_description_service)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from goalwire.entities.standard_types import standard_service
from goalwire.entities.type_support import ActionSupport, MessageSupport, ServiceSupport
from goalwire.errors import peer_text
from goalwire.logging import get_logger
from goalwire.patterns import Pattern
from goalwire.rules.parameters import Descriptor, Type
from goalwire.rules.qos import SERVICES_DEFAULT

if TYPE_CHECKING:
    from type_description_interfaces.msg import IndividualTypeDescription, TypeDescription, TypeSource
    from type_description_interfaces.srv import GetTypeDescription

    from goalwire.entities.node import NodeCore
    from goalwire.entities.parameters.node_parameters import NodeParameters
    from goalwire.idl.model import Default, Definition

START_PARAMETER = 'start_type_description_service'

_SERVICE = 'type_description_interfaces/srv/GetTypeDescription'
_HASH = Pattern(r'RIHS01_[0-9a-f]{64}')


class TypeDescriptions:
    """The service of one node that describes its types."""

    def __init__(self, node: NodeParameters) -> None:
        self._node = node

    def wanted(self) -> bool:
        """Declare the node's parameter unless it is declared already, and return its value."""
        if not self._node.has_parameter(START_PARAMETER):
            descriptor = Descriptor(
                START_PARAMETER,
                Type.BOOL,
                'If enabled, start the ~/get_type_description service.',
                read_only=True,
            )
            self._node.declare_parameter(START_PARAMETER, True, descriptor)
        parameter = self._node.get_parameter(START_PARAMETER)
        if parameter.type_ is Type.BOOL:
            return bool(parameter.value)
        get_logger(self._node.handle.logger_name).error(
            f"Invalid type for parameter '{START_PARAMETER}' {parameter.type_.name!r} should be bool"
        )
        return False

    @classmethod
    def start(cls, node: NodeParameters) -> Any:
        """Make the service of a node and return it; None if the node's parameter switches it off."""
        descriptions = cls(node)
        return descriptions.offer() if descriptions.wanted() else None

    def offer(self) -> Any:
        """Make the service that describes the node's types."""
        make_service = self._node.handle.make_service
        return make_service(
            standard_service(_SERVICE), '~/get_type_description', self._answer, SERVICES_DEFAULT
        )

    def _answer(
        self, request: GetTypeDescription.Request, response: GetTypeDescription.Response
    ) -> GetTypeDescription.Response:
        """Answer with the type that has the request's hash; its name is not compared, as in rcl."""
        core = self._node.handle
        if _HASH.fullmatch(request.type_hash) is None:
            get_logger('rcl').error(f"Failed to parse type hash '{peer_text(request.type_hash)}'")
            response.failure_reason = 'Failed to parse type hash'
            return response
        name = next((name for name, type_hash in types_in_use(core) if type_hash == request.type_hash), None)
        if name is None:
            response.failure_reason = 'Type not currently in use by this node'
            return response
        response.type_description = described(name)
        if request.include_type_sources:
            response.type_sources = sources(name)
        response.successful = True
        return response


def types_in_use(node: NodeCore) -> Iterator[tuple[str, str]]:
    """Yield name and hash of the types of a node's topics, services and actions."""
    for entity in node.owned():
        yield from _name_of(getattr(entity, 'support', None))


def _name_of(support: object) -> Iterator[tuple[str, str]]:
    if isinstance(support, MessageSupport | ServiceSupport):
        yield support.type_name, support.type_hash
    elif isinstance(support, ActionSupport):
        from goalwire.idl import type_hash, type_name

        yield type_name(support.cls), type_hash(support.cls)
        for part in (support.send_goal, support.get_result, support.cancel_goal):
            yield part.type_name, part.type_hash
        for topic in (support.feedback, support.status):
            yield topic.type_name, topic.type_hash


def described(type_name: str) -> TypeDescription:
    """Return the description of 'pkg/msg/Name' (or a service or action) and of all types in it."""
    from type_description_interfaces.msg import TypeDescription

    from goalwire.cdr.type_hash import find_referenced
    from goalwire.idl.rosidl_compat import definition_by_name

    root = definition_by_name(type_name)
    return TypeDescription(
        type_description=_individual(root),
        referenced_type_descriptions=[_individual(item) for item in find_referenced(root)],
    )


def _individual(definition: Definition) -> IndividualTypeDescription:
    from type_description_interfaces.msg import Field, FieldType, IndividualTypeDescription

    from goalwire.cdr.type_hash import described_fields, type_id

    fields = [
        Field(
            name=field.name,
            type=FieldType(
                type_id=type_id(field.type),
                capacity=field.type.capacity,
                string_capacity=field.type.string_capacity,
                nested_type_name=field.type.base if field.type.is_message else '',
            ),
            default_value=_default_text(field.default),
        )
        for field in described_fields(definition)
    ]
    return IndividualTypeDescription(type_name=definition.full_name, fields=fields)


def _default_text(default: Default | None) -> str:
    """Return a default as rosidl writes it: Python's text of the value."""
    if default is None:
        return ''
    return str(default[0] if isinstance(default, bytes) else default)


def sources(type_name: str) -> list[TypeSource]:
    """Return the text of the files that define a type and all types in it.

    Types that are derived from a service's or action's file have no text of their own.
    """
    from type_description_interfaces.msg import TypeSource

    from goalwire.cdr.type_hash import find_referenced
    from goalwire.errors import InterfaceError
    from goalwire.idl.registry import definition_text
    from goalwire.idl.rosidl_compat import definition_by_name

    found = []
    root = definition_by_name(type_name)
    for definition in (root, *find_referenced(root)):
        if '_' in definition.name:
            found.append(TypeSource(type_name=definition.full_name, encoding='implicit'))
            continue
        try:
            text = definition_text(definition.full_name)
        except InterfaceError:  # a class of an installed ROS 2, whose file is not found
            text = ''
        found.append(
            TypeSource(type_name=definition.full_name, encoding=definition.kind, raw_file_contents=text)
        )
    return found
