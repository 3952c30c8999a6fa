"""Computes RIHS01, the hash of a type's description that ROS 2 puts on the wire (REP 2011).

The description of a type and of all types that it contains is written as JSON: only the names and types of
fields, without defaults and constants. Its SHA-256 is the hash. Numbers of types:
type_description_interfaces/msg/FieldType.
"""

from __future__ import annotations

import json
from contextlib import suppress
from functools import cache
from importlib import import_module

from goalwire.errors import InterfaceError
from goalwire.idl.descriptions import Description, IndividualDescription
from goalwire.idl.model import (
    EMPTY_MEMBER,
    Definition,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
    Shape,
)
from goalwire.idl.rosidl_compat import definition_by_name, definition_of, type_name

_MESSAGE = 1
_TYPE_IDS = {
    'int8': 2, 'uint8': 3, 'char': 3, 'int16': 4, 'uint16': 5, 'int32': 6, 'uint32': 7,
    'int64': 8, 'uint64': 9, 'float32': 10, 'float64': 11, 'bool': 15, 'byte': 16, 'string': 17,
    'wstring': 18,
}  # fmt: skip
_BOUNDED_STRING_OFFSET = 4
_SHAPE_OFFSETS = {Shape.SINGLE: 0, Shape.ARRAY: 48, Shape.BOUNDED: 96, Shape.UNBOUNDED: 144}


def type_hash(interface: type | str) -> str:
    """Return 'RIHS01_' and 64 hexadecimal digits for a class or a full name such as 'std_msgs/msg/String'."""
    return _hash_of(interface if isinstance(interface, str) else type_name(interface), interface)


@cache
def _hash_of(full_name: str, interface: type | str) -> str:
    root = definition_by_name(full_name) if isinstance(interface, str) else definition_of(interface)
    description = {
        'type_description': _individual(root),
        'referenced_type_descriptions': [_individual(item) for item in find_referenced(root)],
    }
    return 'RIHS01_' + _sha256(json.dumps(description).encode())


def hash_of_description(description: Description) -> str:
    """Return the hash of a type that another node has described. Equal types have equal hashes."""

    def as_data(one: IndividualDescription) -> dict[str, object]:
        return {
            'type_name': one.type_name,
            'fields': [
                {
                    'name': field.name,
                    'type': {
                        'type_id': field.type.type_id,
                        'capacity': field.type.capacity,
                        'string_capacity': field.type.string_capacity,
                        'nested_type_name': field.type.nested_type_name,
                    },
                }
                for field in one.fields
            ],
        }

    data = {
        'type_description': as_data(description.type_description),
        'referenced_type_descriptions': [as_data(one) for one in description.referenced_type_descriptions],
    }
    return 'RIHS01_' + _sha256(json.dumps(data).encode())


def _sha256(data: bytes) -> str:
    """Return the SHA-256 in hex digits. Python's own module computes it: hashlib loads OpenSSL (3 MB,
    3 ms).
    """
    for module in ('_sha2', '_sha256'):  # the module's name since Python 3.12, and before 3.12
        with suppress(ImportError):
            return str(import_module(module).sha256(data).hexdigest())
    import hashlib

    return hashlib.sha256(data).hexdigest()


def described_fields(definition: Definition) -> tuple[Field, ...]:
    """Return the fields that a type's description lists; for a service or an action, these are its parts."""
    if isinstance(definition, MessageDefinition):
        return definition.fields or (Field(EMPTY_MEMBER, FieldType('uint8')),)
    if isinstance(definition, ServiceDefinition):
        parts = ('request_message', 'response_message', 'event_message')
        return tuple(_part(name, part) for name, part in zip(parts, definition.messages, strict=True))
    return (
        _part('goal', definition.goal),
        _part('result', definition.result),
        _part('feedback', definition.feedback),
        _part('send_goal_service', definition.send_goal),
        _part('get_result_service', definition.get_result),
        _part('feedback_message', definition.feedback_message),
    )


def find_referenced(root: Definition) -> list[Definition]:
    """Return the definitions of all types inside a type, at any depth, sorted by name."""
    found: dict[str, Definition] = {}
    unread = [root]
    while unread:
        for field in described_fields(unread.pop()):
            name = field.type.base
            if field.type.is_message and name not in found:
                found[name] = definition_by_name(name)
                unread.append(found[name])
    if root.full_name in found:
        raise InterfaceError(f'{root.full_name} contains itself')
    return [found[name] for name in sorted(found)]


def type_id(type_: FieldType) -> int:
    """Return the number of a type in type_description_interfaces/msg/FieldType."""
    single = _MESSAGE if type_.is_message else _TYPE_IDS[type_.base]
    return single + (_BOUNDED_STRING_OFFSET if type_.string_capacity else 0) + _SHAPE_OFFSETS[type_.shape]


@cache
def has_buffer_fields(cls: type) -> bool:
    """Tell whether a message class holds, at any depth, an unbounded sequence of primitives.

    Newer rmw_zenoh gives such types side channels ("buffers"). Strings do not count as primitives here.
    """
    return _holds_buffers(definition_of(cls))


def service_hashes(full_name: str) -> tuple[str, str, str]:
    """Return the hashes of 'pkg/srv/Name', of its request and of its response; no class is made."""
    return type_hash(full_name), type_hash(f'{full_name}_Request'), type_hash(f'{full_name}_Response')


def message_facts(full_name: str) -> tuple[str, bool]:
    """Return the hash of 'pkg/msg/Name' and whether it has buffer fields (see `has_buffer_fields`); no class
    is made.
    """
    return type_hash(full_name), _holds_buffers(definition_by_name(full_name))


def _holds_buffers(root: Definition) -> bool:
    return any(
        _is_buffer(field.type) for item in (root, *find_referenced(root)) for field in described_fields(item)
    )


def _is_buffer(type_: FieldType) -> bool:
    return type_.shape is Shape.UNBOUNDED and not type_.is_message and not type_.is_string


def _part(name: str, definition: Definition) -> Field:
    return Field(name, FieldType(definition.full_name))


def _individual(definition: Definition) -> dict[str, object]:
    return {
        'type_name': definition.full_name,
        'fields': [
            {
                'name': field.name,
                'type': {
                    'type_id': type_id(field.type),
                    'capacity': field.type.capacity,
                    'string_capacity': field.type.string_capacity,
                    'nested_type_name': field.type.base if field.type.is_message else '',
                },
            }
            for field in described_fields(definition)
        ],
    }
