"""Functions that generated decoders call.

All of these functions raise ValueError or IndexError for invalid bytes, before they allocate memory for them.
Then cdr/explain.py finds out which field was invalid.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Callable, Iterable, Sequence
from typing import NoReturn

from goalwire.cdr.layout import Item, run_struct

Buffer = bytes | memoryview
Unpack = Callable[[Buffer, int], tuple[object, ...]]

BOOLS = (False, True)  # any other byte raises an IndexError
OCTETS = tuple(bytes((value,)) for value in range(256))
_LENGTHS = {order: struct.Struct(f'{order}I').unpack_from for order in '<>'}
_FOREIGN_ORDER = '>' if sys.byteorder == 'little' else '<'
_SMALL = 2048  # in bytes: up to this size, copying a slice is faster than making a view


def plain_unpackers(items: Iterable[Item], order: str) -> tuple[tuple[Unpack, int], ...]:
    """Return the function that reads a run, and the run's size in bytes, for each `offset & 7`."""
    kept = tuple(items)
    structs = [run_struct(kept, offset, order=order) for offset in range(8)]
    return tuple((run.unpack_from, run.size) for run in structs)


def refuse() -> NoReturn:
    """Raise ValueError: the bytes are not such a message. The decoder makes a DecodeError of it."""
    raise ValueError('malformed message')


def numbers(typecode: str, data: Buffer, at: int, end: int, order: str) -> array[float]:
    """Return data[at:end] as an array of numbers; a large array is copied only once."""
    if end > len(data):
        refuse()
    values: array[float]
    if end - at < _SMALL:
        values = array(typecode, bytes(data[at:end]))
    else:
        values = array(typecode)
        values.frombytes(memoryview(data)[at:end])
    if order == _FOREIGN_ORDER:
        values.byteswap()
    return values


def view_numbers(typecode: str, data: Buffer, at: int, end: int, order: str) -> Sequence[float]:
    """Return a read-only view of data[at:end] as numbers; numbers in the other byte order are copied."""
    if end > len(data):
        refuse()
    if order == _FOREIGN_ORDER:
        return numbers(typecode, data, at, end, order)
    return memoryview(data).toreadonly()[at:end].cast(typecode)  # type: ignore[call-overload, no-any-return]


def swap(typecode: str, data: bytes) -> bytes:
    """Return the bytes of numbers with the byte order of each number reversed."""
    values = array(typecode, data)
    values.byteswap()
    return values.tobytes()


def bools(data: Buffer, at: int, end: int) -> list[bool]:
    """Return the bytes data[at:end], each 0 or 1, as a list of bools."""
    block = bytes(data[at:end])
    if len(block) != end - at or block.strip(b'\0\1'):
        refuse()
    return list(map(bool, block))


def octets(data: Buffer, at: int, end: int) -> list[bytes]:
    """Return the bytes data[at:end] as a list of bytes objects of length 1."""
    if end > len(data):
        refuse()
    return [OCTETS[value] for value in data[at:end]]


def text(data: Buffer, at: int, size: int) -> str:
    """Return the string of `size` bytes at `at`. As in Fast-CDR, the final NUL may be missing."""
    end = at + size
    if end > len(data):
        refuse()
    return str(data[at : end - 1 if size and not data[end - 1] else end], 'utf-8')


def wide_text(data: Buffer, at: int, units: int, order: str) -> str:
    """Return the wstring of `units` four-byte code units at `at`; pairs of surrogates are joined as in
    UTF-16.
    """
    values = numbers('I', data, at, at + 4 * units, order)
    if not units:
        return ''
    greatest = max(values)
    if greatest > sys.maxunicode:
        refuse()
    if greatest <= 0xFFFF:
        return array('H', values).tobytes().decode(f'utf-16-{"le" if sys.byteorder == "little" else "be"}')
    # A value above 0xFFFF shows that the peer wrote code points, not code units: surrogates are then refused.
    return ''.join(chr(int(value)) for value in values).encode().decode()


def texts(data: Buffer, at: int, count: int, order: str, limit: int) -> tuple[list[str], int]:
    """Return `count` strings of at most `limit` bytes (0: of any length) and the offset behind them."""
    if count * 4 > len(data) - at:
        refuse()
    length = _LENGTHS[order]
    most = limit + 1 if limit else 2**32
    found = []
    for _ in range(count):
        at += -at & 3
        (size,) = length(data, at)
        start, at = at + 4, at + 4 + size
        if size > most:
            refuse()
        found.append(text(data, start, size) if data[at - 1] else str(data[start : at - 1], 'utf-8'))
    return found, at


def wide_texts(data: Buffer, at: int, count: int, order: str, limit: int) -> tuple[list[str], int]:
    """Return `count` wstrings of at most `limit` code units (0: of any length) and the offset behind them."""
    if count * 4 > len(data) - at:
        refuse()
    length = _LENGTHS[order]
    found = []
    for _ in range(count):
        at += -at & 3
        (units,) = length(data, at)
        if 0 < limit < units:
            refuse()
        found.append(wide_text(data, at + 4, units, order))
        at += 4 + 4 * units
    return found, at
