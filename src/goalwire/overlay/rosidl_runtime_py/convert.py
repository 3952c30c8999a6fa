"""rosidl_runtime_py.convert: converts a message to an OrderedDict, to YAML, or to comma-separated values."""

from __future__ import annotations

import sys
from array import array
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Protocol, TypeGuard

from rosidl_parser import definition as idl

from goalwire.records import record, replace

if TYPE_CHECKING:
    import numpy as np
    import yaml

__all__ = ['get_message_slot_types', 'message_to_csv', 'message_to_ordereddict', 'message_to_yaml']


class Message(Protocol):
    """The methods of a message class that describe its fields."""

    @property
    def SLOT_TYPES(self) -> tuple[object, ...]: ...

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


@record
class _Style:
    """The rules for shortening values; a length of None means that nothing is shortened."""

    truncate_length: int | None
    no_arr: bool
    no_str: bool

    def exceeded_by(self, value: Sequence[object]) -> bool:
        return self.truncate_length is not None and len(value) > self.truncate_length


def message_to_yaml(
    msg: Message,
    *,
    truncate_length: int | None = None,
    no_arr: bool = False,
    no_str: bool = False,
    flow_style: bool = False,
) -> str:
    """Return the message as a YAML document with its fields in order; `flow_style` puts lists on one line."""
    import yaml

    fields = message_to_ordereddict(msg, truncate_length=truncate_length, no_arr=no_arr, no_str=no_str)
    text: str = yaml.dump(
        fields, Dumper=_dumper(), allow_unicode=True, width=sys.maxsize, default_flow_style=flow_style
    )
    return text


def message_to_csv(
    msg: Message, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> str:
    """Return a message's values in the order of its fields, joined by commas and never quoted."""
    return _csv_message(msg, _Style(truncate_length, no_arr, no_str))


def message_to_ordereddict(
    msg: Message, *, truncate_length: int | None = None, no_arr: bool = False, no_str: bool = False
) -> OrderedDict[str, object]:
    """Return a message's fields in order: nested messages as OrderedDicts, arrays as lists, bytes as text.

    `truncate_length` shortens strings and arrays; `no_arr` and `no_str` replace arrays and strings by a
    description.
    """
    return _to_dict(msg, _Style(truncate_length, no_arr, no_str))


def get_message_slot_types(msg: Message | type[Message]) -> OrderedDict[str, object]:
    """Return the rosidl_parser types of the fields by name, for a message or its class."""
    return OrderedDict(zip(msg.get_fields_and_field_types(), _slot_types(msg), strict=True))


def _slot_types(msg: Message | type[Message]) -> tuple[object, ...]:
    types: tuple[object, ...] = msg.SLOT_TYPES  # type: ignore[assignment]  # of a class, not its property
    return types


def _to_dict(msg: Message, style: _Style) -> OrderedDict[str, object]:
    fields = get_message_slot_types(msg)
    return OrderedDict((name, _convert(getattr(msg, name), style, slot)) for name, slot in fields.items())


def _convert(value: object, style: _Style, slot: object = None) -> object:
    """Return a value as plain Python data; `slot` is the field's type if the value is a whole field."""
    if isinstance(value, bytes):
        return _shorten(value.decode('latin-1'), style)
    if isinstance(value, str):
        return _describe(value) if style.no_str else _shorten(value, style)
    if _is_array(value):
        return _convert_array(value, style, slot)
    if isinstance(value, Mapping):
        whole = replace(style, truncate_length=None)  # keys stay whole: two shortened keys could be equal
        return {_convert(key, whole): _convert(item, style) for key, item in value.items()}
    if _is_numpys(value):
        return value.item()
    if isinstance(value, bool | float | int):
        return value
    return _to_dict(value, style)  # type: ignore[arg-type]  # AttributeError, as in ROS 2, for no message


def _convert_array(value: Sequence[object], style: _Style, slot: object) -> object:
    if style.no_arr and slot is not None:
        return _describe_array(value, slot)
    shown = value[: style.truncate_length]
    items = [_convert(item, style) for item in shown]
    if style.exceeded_by(value):
        items.append('...')
    return tuple(items) if isinstance(value, tuple) else items


def _csv_message(msg: Message, style: _Style) -> str:
    slots = get_message_slot_types(msg).items()
    return _join(_csv(getattr(msg, name), style, slot) for name, slot in slots)


def _csv(value: object, style: _Style, slot: object = None) -> str:
    if _is_array(value):
        if style.no_arr and slot is not None:
            return _describe_array(value, slot)
        parts = [_csv(item, style) for item in value[: style.truncate_length]]
        return _join(iter([*parts, '...'] if style.exceeded_by(value) else parts))
    if isinstance(value, str):
        return _describe(value) if style.no_str else _shorten(value, style)
    if isinstance(value, bytes):
        return str(value[: style.truncate_length] + b'...' if style.exceeded_by(value) else value)
    if isinstance(value, bool | float | int) or _is_numpys(value):
        return str(value)
    return _csv_message(value, style)  # type: ignore[arg-type]  # as above


def _join(parts: Iterator[str]) -> str:
    """Join values by commas; as in ROS 2, empty values at the beginning are left out."""
    result = ''
    for part in parts:
        result = f'{result},{part}' if result else part
    return result


def _is_array(value: object) -> TypeGuard[Sequence[object]]:
    return isinstance(value, list | tuple | array) or type(value).__name__ == 'ndarray'


def _is_numpys(value: object) -> TypeGuard[np.generic]:
    """Return whether a value is a number of numpy, without importing numpy."""
    return type(value).__module__ == 'numpy'


def _shorten(text: str, style: _Style) -> str:
    return f'{text[: style.truncate_length]}...' if style.exceeded_by(text) else text


def _describe(text: str) -> str:
    return f'<string length: <{len(text)}>>'


def _describe_array(value: Sequence[object], slot: object) -> str:
    """Return ROS 2's description of an array whose elements are not shown."""
    if not isinstance(slot, idl.AbstractNestedType):
        return 'unknown'
    name = _item_name(slot.value_type)
    if isinstance(slot, idl.Array):
        return f'<array type: {name}[{slot.size}]>'
    bound = f'[{slot.maximum_size}]' if isinstance(slot, idl.BoundedSequence) else ''
    return f'<sequence type: {name}{bound}, length: {len(value)}>'


def _item_name(item: idl.AbstractNestableType) -> str:
    if isinstance(item, idl.BasicType):
        return item.typename
    if isinstance(item, idl.AbstractGenericString):
        return 'wstring' if isinstance(item, idl.AbstractWString) else 'string'
    if isinstance(item, idl.NamespacedType):
        return '/'.join(item.namespaced_name())
    return item.name if isinstance(item, idl.NamedType) else 'unknown'


@cache
def _dumper() -> type[yaml.SafeDumper]:
    """Return a YAML dumper class that keeps the order of an OrderedDict and writes it in block style."""
    import yaml

    class OrderedDumper(yaml.SafeDumper):
        """A YAML dumper that keeps the order of keys."""

    def represent(dumper: yaml.SafeDumper, data: OrderedDict[str, object]) -> yaml.Node:
        pairs = [(dumper.represent_data(key), dumper.represent_data(item)) for key, item in data.items()]
        return yaml.MappingNode('tag:yaml.org,2002:map', pairs)  # never in flow style, as in ROS 2

    OrderedDumper.add_representer(OrderedDict, represent)
    return OrderedDumper
