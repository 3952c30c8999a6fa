"""Finds message classes by the names of their types, and converts messages to plain data."""

from __future__ import annotations

import math
from typing import Any

from goalwire.errors import GoalwireError, UnknownInterfaceError, peer_text
from goalwire.idl.model import Field, MessageDefinition
from goalwire.idl.rosidl_compat import definition_of

_MOST_ITEMS = 200
_MOST_TEXT = 2000


def interface_class(type_name: str) -> Any:
    """Return the class of 'pkg/kind/Name'. Raises UnknownInterfaceError."""
    from rosidl_runtime_py.utilities import get_interface

    try:
        return get_interface(type_name)
    except (ImportError, AttributeError, ValueError, GoalwireError) as error:
        raise UnknownInterfaceError(
            f"the type '{peer_text(type_name, 200)}' is not known here ({peer_text(error, 200)}): install "
            'its package, or name its folder in GOALWIRE_INTERFACE_PATH'
        ) from None


def fields_of(cls: type) -> tuple[Field, ...]:
    """Return the fields of a message class."""
    definition = definition_of(cls)
    assert isinstance(definition, MessageDefinition)
    return definition.fields


def as_data(value: Any) -> Any:
    """Return a message as types of JSON: long arrays and texts are shortened, NaN and infinities become
    texts.
    """
    if hasattr(value, 'get_fields_and_field_types'):
        return {name: as_data(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, int):
        return value if abs(value) < 2**53 else str(value)  # larger ones lose digits in JavaScript
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return cut(value, _MOST_TEXT)
    if isinstance(value, bytes | bytearray | memoryview):
        return _shorten(list(value[:_MOST_ITEMS]), len(value))
    if hasattr(value, 'item') and not hasattr(value, '__len__'):
        return as_data(value.item())
    if hasattr(value, '__len__'):
        return _shorten([as_data(value[at]) for at in range(min(len(value), _MOST_ITEMS))], len(value))
    return str(value)


def _shorten(items: list[Any], count: int) -> list[Any]:
    return [*items, f'… {count} items'] if count > len(items) else items


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters. A shortened text is followed by the length of the whole
    text.
    """
    return text if len(text) <= most else f'{text[:most]}… ({len(text)} characters)'


def as_dict(message: Any) -> Any:
    """Return a message as types of JSON, without shortening; an array becomes a list."""
    from rosidl_runtime_py import message_to_ordereddict

    if hasattr(message, 'get_fields_and_field_types'):
        return message_to_ordereddict(message)
    return plain(message)


def plain(value: Any) -> Any:
    """Return the value of a field; an array becomes a list."""
    if hasattr(value, 'tolist'):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [as_dict(item) for item in value]
    return value
