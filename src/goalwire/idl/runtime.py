"""Functions that the generated message classes call: conversion of field values, repr and equality.

As in rosidl, primitive sequences are array.array, and fixed primitive arrays are numpy arrays. The import of
numpy takes 0.1 s and 15 MB, and each goal id is a fixed primitive array. So such an array is kept as bytes,
in the little-endian order of CDR, until it is first read; then its property makes the numpy array.
"""

from __future__ import annotations

import reprlib
import struct
import sys
from array import array
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, SupportsIndex

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np

TYPECODES = {
    'int8': 'b', 'uint8': 'B', 'char': 'B', 'int16': 'h', 'uint16': 'H', 'int32': 'i', 'uint32': 'I',
    'int64': 'q', 'uint64': 'Q', 'float32': 'f', 'float64': 'd',
}  # fmt: skip
DTYPES = {
    'b': 'int8', 'B': 'uint8', 'h': 'int16', 'H': 'uint16', 'i': 'int32', 'I': 'uint32',
    'q': 'int64', 'Q': 'uint64', 'f': 'float32', 'd': 'float64',
}  # fmt: skip


class Message(Protocol):
    """The attributes of every message class."""

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]: ...


class _Unset:
    """The default of keyword arguments whose actual default is made anew for every message."""

    def __repr__(self) -> str:
        return '<a new default>'


UNSET = _Unset()


def pack_array(base: str, size: int, values: Iterable[float] | None) -> bytes:
    """Return the bytes of a fixed primitive array that was not read yet: zeros, or the defaults."""
    numbers = [0] * size if values is None else list(values)
    return struct.pack(f'<{len(numbers)}{TYPECODES[base]}', *numbers)


def unpack_array(dtype: str, data: bytes) -> np.ndarray:
    """Return a new numpy array of the values in bytes from `pack_array` or a decoder."""
    import numpy as np

    made = np.frombuffer(bytearray(data), dtype)  # a bytearray makes it writable
    return made if sys.byteorder == 'little' else made.byteswap(inplace=True)


def to_fixed(dtype: str, value: object, field: str = '') -> np.ndarray | bytes:
    """Convert a value for a fixed primitive array to a numpy array; bytes for uint8 stay unchanged."""
    return value if type(value) is bytes and dtype == 'uint8' else to_ndarray(dtype, value, field)


def to_ndarray(dtype: str, value: object, field: str = '') -> np.ndarray:
    """Return a new numpy array with the value's numbers. Errors of numpy get the `field`'s name."""
    import numpy as np

    try:
        return np.array(value, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise _refusal(field, value, dtype, error) from None


def to_array(typecode: str, value: Iterable[float], field: str = '') -> array[float]:
    """Return a new array.array of the value's items.

    A memoryview or numpy array with the same item type is copied as one block of memory. For other values,
    errors of array.array name the `field` and the wrong item.
    """
    if isinstance(value, memoryview):
        same = value.format == typecode and value.ndim == 1 and value.c_contiguous
    else:
        # If another thread is still importing numpy, the value cannot be a numpy array.
        ndarray = getattr(sys.modules.get('numpy'), 'ndarray', None)
        same = (
            ndarray is not None
            and isinstance(value, ndarray)
            and value.ndim == 1
            and value.dtype == DTYPES[typecode]
        )
    if not same:
        try:
            return array(typecode, value)
        except (TypeError, ValueError, OverflowError) as error:
            raise _refusal(field, value, typecode, error) from None
    result: array[float] = array(typecode)
    result.frombytes(value.tobytes())  # type: ignore[attr-defined]
    return result


def _refusal(field: str, value: object, code: str, error: Exception) -> Exception:
    """Return an error, of the class that was raised, for a value that a field cannot hold.

    `code` is the type of the items: array.array's type code for a sequence, numpy's name for a numpy array.
    """
    kind = next(kind for kind in (OverflowError, TypeError, ValueError) if isinstance(error, kind))
    place, wrong = field, value
    if isinstance(value, Sequence) and not isinstance(value, str):
        for index, item in enumerate(value):
            try:
                array(code, (item,)) if code in DTYPES else to_ndarray(code, item)
            except Exception:
                place, wrong = f'{field}[{index}]', item
                break
    dimensions = getattr(value, 'ndim', 1)
    if field and dimensions > 1:
        return kind(
            f"The '{field}' field: a list of numbers has one dimension, this array has {dimensions}: "
            f'write {field}=….ravel()'
        )
    if field and isinstance(value, int | float):
        return kind(f"The '{field}' field: a list is needed, got {value!r}: write {field}=[{value!r}]")
    shown = reprlib.repr(wrong)
    return kind(f"The '{field}' field: {error}; {place} is {shown}" if field else str(error))


def reduce_message(message: object, protocol: SupportsIndex) -> str | tuple[object, ...]:
    """Reduce a message for pickle: as in protocol 2, which supports slots, also for protocols 0 and 1."""
    return object.__reduce_ex__(message, max(int(protocol), 2))


def message_repr(message: Message) -> str:
    """Return the same repr as rosidl: package.kind.Name(field=value, …), with sequences as lists."""
    cls = type(message)
    fields = (f'{name}={_value_repr(getattr(message, name))}' for name in cls.get_fields_and_field_types())
    return f'{cls.__module__.rpartition(".")[0]}.{cls.__name__}({", ".join(fields)})'


def _value_repr(value: object) -> str:
    return repr(value.tolist()) if isinstance(value, array) else repr(value)


def arrays_equal(one: np.ndarray, other: np.ndarray) -> bool:
    """Compare two fixed primitive arrays value by value; NaN is unequal to itself, as usual."""
    return one.shape == other.shape and bool((one == other).all())
