"""Bags as Parquet: a file for each topic, with a typed column for each field.

Fields of nested messages are columns of their own, such as `pose.x`. Sequences become lists, sequences of
messages become lists of structs, and sequences of bytes become binary.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import ExitStack
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from goalwire.apps.bag.exporting.folders import Written, file_stems, new_folder
from goalwire.errors import BagError
from goalwire.idl.model import Field, FieldType, Shape
from goalwire.idl.registry import message_definition
from goalwire.observe.messages import fields_of
from goalwire.rosbag2.types import class_of

if TYPE_CHECKING:
    import pyarrow as pa

    from goalwire.rosbag2.model import Message
    from goalwire.rosbag2.reader import Reader

_GROUP_ROWS = 10_000
_GROUP_BYTES = 32 << 20
"""A row group is written when it has _GROUP_ROWS rows, or its messages have _GROUP_BYTES bytes."""
_BYTES = {'uint8', 'char', 'byte'}
_ARROW = {'bool': 'bool_', 'byte': 'uint8', 'char': 'uint8', 'wstring': 'string'}
"""Arrow's names of types by ROS 2's names, if the two names differ."""


class Column(NamedTuple):
    """A column: its name, its type, and the function that gets its value from a message."""

    name: str
    type: pa.DataType
    value: Callable[[Any], Any]


class _File:
    """The file of one topic."""

    def __init__(self, path: Path, cls: type) -> None:
        import pyarrow as pa
        from pyarrow.parquet import ParquetWriter

        time = pa.timestamp('ns', tz='UTC')
        self.path = path
        self.count = 0
        self._columns = columns_of(cls)
        self._schema = pa.schema(
            [('time', time), ('sent', time), *((column.name, column.type) for column in self._columns)]
        )
        self._rows: list[list[Any]] = [[] for _ in self._schema]
        self._byte_count = 0
        self._writer = ParquetWriter(path, self._schema, compression='zstd')

    def add(self, message: Message, decoded: Any) -> None:
        """Add a row."""
        values = (message.time, message.sent, *(column.value(decoded) for column in self._columns))
        for rows, value in zip(self._rows, values, strict=True):
            rows.append(value)
        self.count += 1
        self._byte_count += len(message.data)
        if len(self._rows[0]) >= _GROUP_ROWS or self._byte_count >= _GROUP_BYTES:
            self._write_group()

    def _write_group(self) -> None:
        import pyarrow as pa

        arrays = [
            pa.array(rows, type=field.type) for rows, field in zip(self._rows, self._schema, strict=True)
        ]
        self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._schema))
        self._rows = [[] for _ in self._schema]
        self._byte_count = 0

    def close(self) -> None:
        """Write the last row group and the end of the file."""
        try:
            if self._rows[0]:
                self._write_group()
        finally:
            self._writer.close()


def write_parquet(bag: Reader, topics: Collection[str], start: int, folder: Path) -> list[Written]:
    """Write the messages of topics that were recorded at `start` (in ns) or later.

    Raises BagError (also if pyarrow is missing), InterfaceError, DecodeError and OSError.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ModuleNotFoundError as error:
        raise BagError(
            f"Parquet needs the package '{error.name}'; run: pip install 'goalwire[parquet]'"
        ) from None
    stems = file_stems(topics)
    described = {topic.name: topic for topic in bag.topics}
    new_folder(folder)
    files: dict[str, _File] = {}
    with ExitStack() as stack:
        for message, decoded in bag.decoded(topics, start):
            file = files.get(message.topic)
            if file is None:
                path = folder / f'{stems[message.topic]}.parquet'
                file = files[message.topic] = _File(path, class_of(described[message.topic], bag.topics))
                stack.callback(file.close)
            file.add(message, decoded)
    return [Written(file.path, file.count) for file in files.values()]


# -- columns -------------------------------------------------------------------------------------------------


def columns_of(cls: type) -> list[Column]:
    """Return the columns for the messages of a class."""
    return _columns(fields_of(cls), '')


def _columns(fields: Collection[Field], before: str) -> list[Column]:
    found: list[Column] = []
    for field in fields:
        path = f'{before}{field.name}'
        if field.type.is_message and field.type.shape is Shape.SINGLE:
            found += _columns(message_definition(field.type.base).fields, f'{path}.')
        else:
            get, convert = attrgetter(path), _converter(field.type)
            value = get if convert is None else _both(get, convert)
            found.append(Column(path, _arrow_type(field.type), value))
    return found


def _both(get: Callable[[Any], Any], convert: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda message: convert(get(message))


def _arrow_type(type_: FieldType) -> pa.DataType:
    import pyarrow as pa

    if type_.shape is not Shape.SINGLE and type_.base in _BYTES:
        return pa.binary()
    if type_.is_message:
        fields = message_definition(type_.base).fields
        item = pa.struct([(field.name, _arrow_type(field.type)) for field in fields])
    else:
        item = getattr(pa, _ARROW.get(type_.base, type_.base))()
    return item if type_.shape is Shape.SINGLE else pa.list_(item)


def _converter(type_: FieldType) -> Callable[[Any], Any] | None:
    """Return the function that converts a field's value for Arrow; None if Arrow takes the value itself."""
    if type_.shape is Shape.SINGLE:
        if type_.is_message:
            return _structure(type_)
        return (lambda value: value[0]) if type_.base == 'byte' else None
    if type_.base == 'byte':
        return b''.join
    if type_.base in _BYTES:
        return bytes
    if type_.is_message:
        item = _structure(type_)
        return lambda values: [item(value) for value in values]
    return np.asarray if type_.is_number else list


def _structure(type_: FieldType) -> Callable[[Any], dict[str, Any]]:
    parts = [(field.name, _converter(field.type) or _same) for field in message_definition(type_.base).fields]
    return lambda message: {name: convert(getattr(message, name)) for name, convert in parts}


def _same(value: Any) -> Any:
    return value
