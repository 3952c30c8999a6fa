"""Makes the help text of a message class, and a notebook's view of a message; loaded only when needed.

help() and `?` show the definition, with its comments and units. A notebook shows the beginning of long
sequences, and an Image or CompressedImage as a picture.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from inspect import Parameter, Signature
from typing import Any

from goalwire.errors import InterfaceError, RemoteError
from goalwire.idl import registry
from goalwire.idl.class_source import copy_default, single_default
from goalwire.idl.model import (
    ActionDefinition,
    Definition,
    Field,
    MessageDefinition,
    ServiceDefinition,
    Shape,
)
from goalwire.idl.runtime import TYPECODES

_PARTS = {'srv': ('Request', 'Response'), 'action': ('Goal', 'Result', 'Feedback')}
"""The parts that a service's or an action's file defines, in the file's order; ROS 2 derives the rest."""
_SEPARATOR = '---'
_LONGEST = 8
"""The most elements of a sequence that a notebook shows."""
_LONGEST_TEXT = 200


def document(defined: Definition) -> str:
    """Return the docstring of a class: its kind, and the text that defines it."""
    kinds = {ServiceDefinition: 'Service', ActionDefinition: 'Action'}
    head = f'{kinds.get(type(defined), "Message")} class {defined.name!r}.'
    text = _definition_text(defined)
    return f'{head}\n\n{text}' if text else head


def _definition_text(defined: Definition) -> str:
    owner, _, part = defined.name.partition('_')
    parts = _PARTS.get(defined.kind, ())
    if not part or part in parts:
        try:
            lines = registry.definition_text(f'{defined.package}/{defined.kind}/{owner}').splitlines()
        except InterfaceError:  # the file was removed: show the fields that were read before
            pass
        else:
            return '\n'.join(_part_of(lines, parts.index(part)) if part else lines).strip('\n')
    fields = defined.fields if isinstance(defined, MessageDefinition) else ()
    return '\n'.join(f'{field.type.text} {field.name}' for field in fields)


def _part_of(lines: list[str], number: int) -> Iterator[str]:
    at = 0
    for line in lines:
        if line.strip() == _SEPARATOR:
            at += 1
        elif at == number:
            yield line


class _Written:
    """A default that is made anew for each message; its repr is the expression that makes it."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


def signature(message: MessageDefinition) -> Signature:
    """Return the signature of a message's constructor, with defaults as Python code shows them."""
    defaults = {field.name: _default(field) for field in message.fields} | {'check_fields': False}
    return Signature(
        [Parameter(name, Parameter.KEYWORD_ONLY, default=value) for name, value in defaults.items()]
    )


def _default(field: Field) -> object:
    if field.default is not None:
        return copy_default(field)
    if field.type.shape is Shape.SINGLE and not field.type.is_message:
        return single_default(field)
    if field.type.shape is Shape.SINGLE:
        return _Written(f'{field.type.base.rpartition("/")[2]}()')
    if field.type.shape is not Shape.ARRAY:
        return array(TYPECODES[field.type.base]) if field.type.is_number else []
    element = 0 if field.type.is_number else _Written('…')
    return _Written(f'[{element!r}] * {field.type.capacity}')


def shorten(value: object, level: int = 0) -> str:
    """Return the text that a notebook shows: the repr, with long sequences and texts cut short."""
    fields = getattr(type(value), '_fields_and_field_types', None)
    if isinstance(fields, dict):
        kept = ', '.join(f'{name}={shorten(getattr(value, name), level + 1)}' for name in fields)
        name = type(value).__name__
        return f'{name}({kept})' if level else f'{type(value).__module__.rpartition(".")[0]}.{name}({kept})'
    if isinstance(value, str | bytes):
        end = f'… ({len(value):,} in all)' if len(value) > _LONGEST_TEXT else ''
        return f'{value[:_LONGEST_TEXT]!r}{end}'
    if hasattr(value, 'tolist') or isinstance(value, list | tuple):
        sequence: Any = value
        shown = [shorten(item, level + 1) for item in list(sequence[:_LONGEST])]
        more = [f'… {len(sequence):,} in all'] if len(sequence) > _LONGEST else []
        return f'[{", ".join([*shown, *more])}]'
    return repr(value)


def picture(message: object, kind: str) -> bytes | None:
    """Return an image message as a file of the media type `kind`; None for other types and faulty images."""
    from goalwire.idl.pictures import as_file

    try:
        found, data = as_file(message)
    except RemoteError:
        return None
    return data if found == kind else None
