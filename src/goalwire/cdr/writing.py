"""Functions and tables that generated encoders call, for values that need more than a struct.

All of these functions raise TypeError or ValueError for a value that does not fit its field. Then
cdr/explain.py finds out which field it was.
"""

from __future__ import annotations

import sys
from array import array
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import TYPE_CHECKING, NoReturn

from goalwire.cdr.layout import COUNT, TEXT, Item, run_struct
from goalwire.idl.runtime import to_array

if TYPE_CHECKING:
    import numpy as np

Pack = Callable[..., bytes]
Add = Callable[[object], None]
_KEPT_TEXT = 256  # in bytes: structs for longer texts are not kept


class TextPackers(dict[int, Pack]):
    """The functions that pack a run with one text, by `size << 3 | offset & 7`; each is made when first
    needed.
    """

    def __init__(self, items: Iterable[Item], prefix: str = '') -> None:
        super().__init__()
        self._items = tuple(items)
        self._prefix = prefix

    def __missing__(self, key: int) -> Pack:
        size, offset = key >> 3, key & 7
        pack: Pack = run_struct(self._items, offset, prefix=self._prefix, text=size).pack
        if size <= _KEPT_TEXT:
            self[key] = pack
        return pack


def plain_packers(items: Iterable[Item]) -> tuple[Pack, ...]:
    """Return the functions that pack a run without a text, one for each value of `offset & 7`."""
    kept = tuple(items)
    return tuple(run_struct(kept, offset).pack for offset in range(8))


_TEXTS = TextPackers((COUNT, TEXT))


def refuse(*_: object) -> NoReturn:
    """Raise ValueError: a value does not fit its field."""
    raise ValueError('a value does not fit its field')


def require(wanted: type, *values: object) -> None:
    """Raise TypeError for values of another type; values of subclasses are accepted."""
    for value in values:
        if not isinstance(value, wanted):
            raise TypeError(f'expected {wanted.__name__}, got {type(value).__name__}')


def wide(text: str) -> bytes:
    """Return a wstring: four bytes for each UTF-16 code unit, as Fast-CDR writes wchar_t, without a final
    NUL.
    """
    require(str, text)
    units = array('H')
    units.frombytes(text.encode('utf-16-le' if sys.byteorder == 'little' else 'utf-16-be'))
    return little_endian(array('I', units))


def put_texts(texts: Iterable[str], add: Add, at: int, limit: int) -> int:
    """Add strings of at most `limit` bytes (0: of any length) and return the offset behind them."""
    if texts.__class__ is str:
        refuse()  # else each letter would be written as a text
    most = limit + 1 if limit else 2**32
    for text in texts:
        if type(text) is not str:
            require(str, text)
        data = text.encode()
        size = len(data) + 1
        if 0 in data or size > most:
            refuse()
        packed = _TEXTS[size << 3 | at & 7](size, data)
        add(packed)
        at += len(packed)
    return at


def put_wide_texts(texts: Iterable[str], add: Add, at: int, limit: int) -> int:
    """Add wstrings of at most `limit` code units (0: of any length) and return the offset behind them."""
    if texts.__class__ is str:
        refuse()
    for text in texts:
        data = wide(text)
        units = len(data) >> 2
        if 0 < limit < units:
            refuse()
        packed = _TEXTS[len(data) << 3 | at & 7](units, data)
        add(packed)
        at += len(packed)
    return at


def numbers(typecode: str, value: Iterable[float]) -> array[float]:
    """Convert a value to an array.array of the given typecode."""
    if isinstance(value, (bytes, bytearray)) and typecode not in 'bB':
        refuse()  # array.array would take the bytes as raw memory
    return to_array(typecode, value)


def numbers_in_place(typecode: str, value: Iterable[float]) -> Sequence[float]:
    """Return a memoryview of numbers of the right type unchanged, and any other value as an array.array."""
    if isinstance(value, memoryview) and value.format == typecode and value.c_contiguous and value.ndim == 1:
        return value
    return numbers(typecode, value)


class NumpyTypes(dict[str, 'np.dtype[np.generic]']):
    """numpy's dtypes by their names, such as '<f8'; numpy is imported when the first dtype is needed."""

    def __missing__(self, name: str) -> np.dtype[np.generic]:
        import numpy as np

        found: np.dtype[np.generic] = np.dtype(name)
        self[name] = found
        return found


def fixed_numbers(value: object, dtype: np.dtype[np.generic], size: int) -> np.ndarray:
    """Return a numpy array in little-endian order; raises TypeError for another dtype or size."""
    import numpy as np

    if not isinstance(value, np.ndarray) or value.dtype.newbyteorder('<') != dtype or value.size != size:
        raise TypeError('no numpy array of this type and size')
    return value.astype(dtype)


def bools(values: Collection[bool]) -> bytes:
    """Return bools as bytes; refuses other values, even if they are truthy or falsy."""
    listed = values if isinstance(values, (list, tuple)) else list(values)
    if not _ONLY_BOOL.issuperset(map(type, listed)):
        for value in listed:
            if not (isinstance(value, bool) or type(value).__name__ in ('bool_', 'bool')):
                refuse()
    return bytes(map(bool, listed))


def octets(values: Collection[bytes] | bytes | bytearray) -> bytes:
    """Join bytes objects of length 1; a bytes object of any length is accepted in place of the collection."""
    if isinstance(values, (bytes, bytearray)):
        return bytes(values)
    for value in values:
        require(bytes, value)
        if len(value) != 1:
            refuse()
    return b''.join(values)


def little_endian(values: array[int] | array[float]) -> bytes:
    """Return the bytes of an array in little-endian order, as on the wire."""
    if sys.byteorder == 'big':
        values = values[:]
        values.byteswap()
    return values.tobytes()


_ONLY_BOOL = frozenset({bool})
