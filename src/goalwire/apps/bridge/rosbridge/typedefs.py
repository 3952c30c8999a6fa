"""Descriptions of types as rosapi gives them (rosapi_msgs/msg/TypeDef)."""

from __future__ import annotations

from typing import Any

from goalwire.idl.model import FieldType, MessageDefinition, Shape
from goalwire.idl.registry import message_definition
from goalwire.idl.rosidl_compat import definition_of
from goalwire.idl.slot_types import IDL_NAMES


def typedefs(cls: Any) -> list[dict[str, Any]]:
    """Return the description of a message class, then those of the messages in it, each once."""
    root = definition_of(cls)
    assert isinstance(root, MessageDefinition)
    found: list[dict[str, Any]] = []
    waiting, seen = [root], {root.full_name}
    while waiting:
        definition = waiting.pop(0)
        found.append(_typedef(definition))
        for field in definition.fields:
            if field.type.is_message and field.type.base not in seen:
                seen.add(field.type.base)
                waiting.append(message_definition(field.type.base))
    return found


def _typedef(definition: MessageDefinition) -> dict[str, Any]:
    fields = definition.fields
    return {
        'type': _short(definition.full_name),
        'fieldnames': [field.name for field in fields],
        'fieldtypes': [_short(IDL_NAMES.get(field.type.base, field.type.base)) for field in fields],
        'fieldarraylen': [_array_length(field.type) for field in fields],
        'examples': [_example(field.type) for field in fields],
        'constnames': [constant.name for constant in definition.constants],
        'constvalues': [str(constant.value) for constant in definition.constants],
    }


def _short(name: str) -> str:
    parts = name.split('/')
    return name if len(parts) == 1 else f'{parts[0]}/{parts[-1]}'


def _array_length(type_: FieldType) -> int:
    """Return -1 for a single value, 0 for a sequence, else the length of the array."""
    return {Shape.SINGLE: -1, Shape.ARRAY: type_.capacity}.get(type_.shape, 0)


def _example(type_: FieldType) -> str:
    if type_.shape is not Shape.SINGLE:
        return '[]'
    if type_.is_message:
        return '{}'
    if type_.is_string:
        return ''
    return {'bool': 'False', 'float32': '0.0', 'float64': '0.0'}.get(type_.base, '0')
