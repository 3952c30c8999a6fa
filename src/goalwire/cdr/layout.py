"""The layout of messages in XCDR1: sizes, alignments, and runs of fields of fixed size.

A value of size s starts at a multiple of s, counted from the end of the 4-byte header. Offsets here count
from the header's first byte. So `offset & 7` alone gives the alignment of a run's start.
"""

from __future__ import annotations

import builtins
import struct
from collections.abc import Collection, Iterable
from functools import cache

from goalwire.idl import classes
from goalwire.idl.model import FieldType, MessageDefinition, Shape
from goalwire.idl.rosidl_compat import definition_of
from goalwire.records import record

HEADER_SIZE = 4

# struct's codes of the types; their sizes are also their alignments. Decoders read a bool as a number, to
# refuse values other than 0 and 1.
CODES = {
    'bool': '?', 'byte': 'c', 'char': 'B', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H',
    'int32': 'i', 'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'float32': 'f', 'float64': 'd',
}  # fmt: skip
SIZES = {base: struct.calcsize(f'<{code}') for base, code in CODES.items()}


@record
class Leaf:
    """A field of a message class; `cls` is the message class of its value or values, if these are messages.

    `is_packed` is True if the slot of a fixed array of numbers may contain bytes, as in goalwire's own
    classes: see idl/runtime.py.
    """

    name: str
    type: FieldType
    cls: builtins.type | None
    is_packed: bool


@record
class Item:
    """A value of fixed size inside a run; the size of TEXT is known only at run time."""

    code: str
    size: int
    alignment: int

    @staticmethod
    def of(base: str) -> Item:
        return Item(CODES[base], SIZES[base], SIZES[base])

    @staticmethod
    def block(size: int, alignment: int) -> Item:
        return Item(f'{size}s', size, alignment)


COUNT = Item.of('uint32')
EMPTY = Item('x', 1, 1)  # the single byte of a message without fields
TEXT = Item('', 0, 1)


@cache
def leaves(cls: type) -> tuple[Leaf, ...]:
    """Return the fields of a message class that goalwire or rosidl has made; raises TypeError for anything
    else.
    """
    definition = definition_of(cls)
    if not isinstance(definition, MessageDefinition):
        raise TypeError(f'{definition.full_name} is a service or an action; only messages have bytes')
    is_own = classes.own_definition(cls) is not None
    return tuple(
        Leaf(
            field.name,
            field.type,
            classes.find_class(field.type.base) if field.type.is_message else None,
            is_own and field.type.is_number and field.type.shape is Shape.ARRAY,
        )
        for field in definition.fields
    )


@cache
def minimum_size(cls: type) -> int:
    """Return the least number of bytes that a message takes, without padding; never 0."""
    return sum(map(_leaf_minimum, leaves(cls))) or EMPTY.size


def element_minimum(leaf: Leaf) -> int:
    """Return the least number of bytes that one value of a field takes."""
    if leaf.cls is not None:
        return minimum_size(leaf.cls)
    return COUNT.size if leaf.type.is_string else SIZES[leaf.type.base]


def _leaf_minimum(leaf: Leaf) -> int:
    if leaf.type.is_sequence:
        return COUNT.size
    return element_minimum(leaf) * (leaf.type.capacity if leaf.type.shape is Shape.ARRAY else 1)


@cache
def texts_inside(cls: type) -> int | None:
    """Return the number of strings in a message; None if anything else in the message varies in size."""
    total = 0
    for leaf in leaves(cls):
        single = leaf.type.shape is Shape.SINGLE
        if leaf.cls is not None and single:
            inside = texts_inside(leaf.cls)
            if inside is None:
                return None
            total += inside
        elif leaf.type.is_string and single:
            total += 1
        elif leaf.type.is_sequence or leaf.cls is not None or leaf.type.is_string:
            return None
    return total


def stride(items: Collection[Item], order: str = '<') -> tuple[struct.Struct, int] | None:
    """Return the struct and the alignment of a sequence's messages; None if their padding differs.

    CDR aligns values, not messages: only if the first item has the greatest alignment, each message starts at
    a multiple of it and has the same padding.
    """
    run = run_struct(items, HEADER_SIZE, order=order)
    first, greatest = next(iter(items)).alignment, max(item.alignment for item in items)
    return None if first < greatest or run.size % greatest else (run, greatest)


def run_struct(
    items: Iterable[Item], offset: int, *, order: str = '<', prefix: str = '', text: int = 0
) -> struct.Struct:
    """Return the struct of items that start at `offset`, padding included; TEXT is `text` bytes long."""
    codes = [order, prefix]
    at = offset + struct.calcsize(f'<{prefix}')
    for item in items:
        size = text if item is TEXT else item.size
        padding = -(at - HEADER_SIZE) % item.alignment
        codes.append('x' * padding + (f'{text}s' if item is TEXT else item.code))
        at += padding + size
    return struct.Struct(''.join(codes))
