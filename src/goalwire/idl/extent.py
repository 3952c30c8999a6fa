"""The size of a message: its depth, fields and values. A definition beyond the limits is refused."""

from __future__ import annotations

from collections.abc import Mapping

from goalwire.errors import InterfaceSyntaxError
from goalwire.idl.model import Field, MessageDefinition, Shape
from goalwire.records import record

MAX_DEPTH = 64
"""The most levels of nested messages: each level is a call in constructors, encoders and decoders."""
MAX_FIELDS = 10_000
"""The most fields of a message, nested fields included, since encoders have code for each of them."""
MAX_VALUES = 2**22
"""The most values of a new message; 1024 numbers of an array count as one value."""
_NUMBERS_PER_VALUE = 1024


@record
class Extent:
    """The size of a message type: its levels, fields and values, those of nested messages included."""

    depth: int = 1
    fields: int = 1
    values: int = 1


ONE = Extent()


def extent_of(message: MessageDefinition, nested: Mapping[str, Extent]) -> Extent:
    """Return the extent of a message; raises InterfaceSyntaxError at the field that exceeds a limit.

    `nested` has the extents of nested messages, by full name. Fields that are in no file, since ROS 2 derives
    them (such as those of a service's event), are not checked.
    """
    depth, fields, values = 1, 1, 1
    for field in message.fields:
        inner = nested.get(field.type.base, ONE)
        depth = max(depth, inner.depth + 1 if field.type.is_message else 1)
        fields += inner.fields
        values += _values(field, inner)
        if field.line:
            _check(message, field, depth, MAX_DEPTH, 'levels of messages inside messages')
            _check(message, field, fields, MAX_FIELDS, 'fields, those of nested messages counted')
            _check(message, field, values, MAX_VALUES, 'values in each new message')
    return Extent(depth, fields, values)


def too_deep(message: MessageDefinition, field: Field) -> InterfaceSyntaxError:
    """Return the error for a field whose message is nested too deeply."""
    return _error(message, field, f'more than {MAX_DEPTH} levels of messages inside messages')


def _values(field: Field, inner: Extent) -> int:
    type_ = field.type
    if type_.is_sequence:
        return 1
    if type_.shape is Shape.SINGLE:
        return inner.values
    if type_.is_number:
        return 1 + type_.capacity // _NUMBERS_PER_VALUE
    return 1 + type_.capacity * inner.values


def _check(message: MessageDefinition, field: Field, found: int, most: int, what: str) -> None:
    if found > most:
        raise _error(message, field, f'{found:,} {what}; {most:,} are allowed')


def _error(message: MessageDefinition, field: Field, problem: str) -> InterfaceSyntaxError:
    advice = 'use a sequence (Type[]), or fewer and larger fields'
    return InterfaceSyntaxError(
        message.source, field.line, 1, f'field {field.name}: {message.name} has {problem}: {advice}'
    )
