"""Converts messages to bytes and back: XCDR1, written in little endian, read in little or big endian.

The source of an encoder or decoder is generated when a message class first needs it, and the function is
kept. This works for any class with rosidl's attributes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING, Any, TypeVar, cast

from goalwire.cdr import explain, layout, reading, writing
from goalwire.cdr.decoder_source import decoder_source
from goalwire.cdr.encoder_source import encoder_source
from goalwire.idl.generated_code import run_source
from goalwire.idl.rosidl_compat import type_name

if TYPE_CHECKING:
    from goalwire.payload_parts import Parts

PARTS_FROM = 1 << 16
"""A message of this many bytes or more is not joined by `payload_encoder`. Smaller ones go over sockets."""
_BYTES_A_PART = 4096
"""A message whose buffers have fewer bytes on average is joined, too: many small copies take longer than a
second copy of the whole.
"""

Data = bytes | bytearray | memoryview
MessageT = TypeVar('MessageT')


def encode(message: object) -> bytes:
    """Return a message as CDR, header included; raises EncodeError if a value does not fit its field."""
    cls: type = type(message)
    return encoder(cls)(message)


def decode(data: Data, cls: type[MessageT]) -> MessageT:
    """Return the message in CDR bytes; raises DecodeError for bytes that are not a message of this class."""
    return cast('MessageT', decoder(cls)(data))


@cache
def encoder(cls: type) -> Callable[[object], bytes]:
    """Return `encode(message) -> bytes` for one message class."""
    source, names = encoder_source(cls)
    names['explain'] = partial(explain.explain_encode, cls)
    return cast(
        'Callable[[object], bytes]',
        _compile(source, names, f'encoder {type_name(cls)}', 'encode'),
    )


@cache
def parts_encoder(cls: type) -> Callable[[object], list[Data]]:
    """Return a function `encode(message)` for one message class that does not copy memoryviews in sequences.

    The function returns a list of buffers that together are the message.
    """
    source, names = encoder_source(cls, outcome='out')
    names['explain'] = partial(explain.explain_encode, cls)
    names['numbers'] = writing.numbers_in_place
    return cast(
        'Callable[[object], list[Data]]',
        _compile(source, names, f'<goalwire encoder {type_name(cls)}, in parts>', 'encode'),
    )


@cache
def has_numbers(cls: type) -> bool:
    """Tell whether a message class, or a message inside it, has a sequence of numbers, which may be large."""
    return any(
        (leaf.type.is_number and leaf.type.is_sequence) or (leaf.cls is not None and has_numbers(leaf.cls))
        for leaf in layout.leaves(cls)
    )


@cache
def payload_encoder(cls: type) -> Callable[[object], bytes | Parts]:
    """Return a function `encode(message)` for one message class that does not join large messages.

    It returns Parts for a message of PARTS_FROM bytes or more in large buffers, and bytes for any other one.
    """
    from goalwire.payload_parts import Parts  # imported here: few programs publish large messages

    is_joined = f'at < {PARTS_FROM} or at < {_BYTES_A_PART} * len(out)'
    outcome = f"b''.join(out) if {is_joined} else parts_of(out, at)"
    source, names = encoder_source(cls, outcome=outcome)
    names['explain'] = partial(explain.explain_encode, cls)
    names['numbers'] = writing.numbers_in_place
    names['parts_of'] = partial(Parts, type_name=type_name(cls))
    return cast(
        'Callable[[object], bytes | Parts]',
        _compile(source, names, f'<goalwire encoder {type_name(cls)}, payload>', 'encode'),
    )


def decoder(cls: type, *, in_place: bool = False) -> Callable[[Data], Any]:
    """Return `decode(data) -> message` for one message class.

    With `in_place` the message's sequences of numbers are read-only views of `data` instead of copies.
    """
    return _decoder(cls, '<', view=False, in_place=in_place)


@cache
def _decoder(cls: type, order: str, *, view: bool, in_place: bool) -> Callable[[Data], Any]:
    source, names = decoder_source(cls, order, view=view)
    names['explain'] = partial(explain.explain_decode, cls)
    names['otherwise'] = partial(_decode_otherwise, cls, in_place=in_place)
    if in_place:
        names['numbers'] = reading.view_numbers
    kind = f'{"big" if order == ">" else "little"} endian{" view" if view else ""}{" in place" * in_place}'
    return cast(
        'Callable[[Data], Any]',
        _compile(source, names, f'decoder {type_name(cls)}, {kind}', 'decode'),
    )


def _decode_otherwise(cls: type, data: Data, *, in_place: bool) -> object:
    """Decode data that is not of class bytes, or whose header does not say little endian."""
    if not isinstance(data, (bytes, bytearray, memoryview)):
        raise TypeError(f'expected bytes, got {type(data).__name__}')
    if isinstance(data, bytes):
        return _decoder(cls, explain.byte_order(cls, data), view=False, in_place=in_place)(data)
    view = memoryview(data)
    view = view.cast('B') if view.c_contiguous else memoryview(bytes(view))
    return _decoder(cls, explain.byte_order(cls, view), view=True, in_place=in_place)(view)


def _compile(source: str, names: dict[str, object], title: str, function: str) -> object:
    run_source(source, names, title)
    return names[function]
