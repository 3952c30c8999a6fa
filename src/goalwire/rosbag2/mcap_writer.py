"""Writes one MCAP file that can be read at any moment, whatever ends the process.

A file of MCAP ends with a summary and a footer, without which most readers refuse it. So the end (summary and
footer) is written many times: each new chunk overwrites it, and a new end follows. The old end is cut off
before that, so the file can be read at each moment: it has an end, or it stops after its last chunk, as after
a power failure.

The end grows with the file. It is written at each flush, and after a chunk if it adds at most a twentieth to
the bytes written since the last end. Its counts are right for the file at that moment.

The library `mcap` encodes the records, except those of messages and chunks: encoding these here is faster.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import NamedTuple

import mcap.writer as library
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Statistics,
    SummaryOffset,
)
from mcap.records import Schema as SchemaRecord

from goalwire.rosbag2.metadata import qos_text
from goalwire.rosbag2.model import Message, Topic

CHUNK_BYTES = 2**20
PROFILE = 'ros2'
METADATA_NAME = 'rosbag2'
METADATA_KEY = 'serialized_metadata'
_END_SHARE = 20
"""An end is written after a chunk if the bytes since the last end are this many times the end's size."""
_MESSAGE = struct.Struct('<BQHIQQ')
_CHUNK = struct.Struct('<BQQQQI')
_INDEX = struct.Struct('<BQHI')
_INDEX_ENTRY = struct.Struct('<QQ')
_FOOTER = struct.Struct('<BQQQ')
_PIECES = 512
"""The largest number of buffers that one system call writes; if there are more, they are joined first."""

Compress = Callable[[bytes], bytes]


class Compression(NamedTuple):
    """How chunks are compressed: MCAP's name of the compression, and the function that compresses."""

    name: str = ''
    compress: Compress | None = None


class _Chunk(NamedTuple):
    """A chunk that is in the file."""

    offset: int
    summary: bytes
    """The summary's record (chunk index) for this chunk."""
    counts: dict[int, int]
    """The number of this chunk's messages by channel."""


class McapWriter:
    """Writes a new file. Only one thread may use it, except for `sync`, which any thread may call."""

    def __init__(
        self,
        path: str,
        *,
        compression: Compression = Compression(),  # noqa: B008 - immutable
        chunk_bytes: int = CHUNK_BYTES,
    ) -> None:
        """Make the file; raises OSError, FileExistsError."""
        self.path = path
        self._compression = compression
        self._chunk_bytes = chunk_bytes
        self._channels: dict[str, int] = {}
        self._schemas: dict[tuple[str, str], int] = {}
        self._schema_records: list[bytes] = []
        self._channel_records: list[bytes] = []
        self._unwritten: list[bytes] = []
        """Schemas and channels that are not in the file yet; they are written before the next chunk."""
        self._parts: list[bytes] = []
        self._size = 0
        self._indices: dict[int, list[bytes]] = defaultdict(list)
        self._chunk_start = self._chunk_end = 0
        self._chunks: list[_Chunk] = []
        self._counts: dict[int, int] = defaultdict(int)
        self.start = self.end = 0
        """The times of the earliest and the latest message, in ns."""
        self.count = 0
        """How many messages the file has, including those that wait for their chunk to fill up."""
        self._has_end = False
        self._end_size = 0
        """The size, in bytes, of the end of the file (index and footer) as it was last written."""
        self._since_end = 0
        self._data_end = 0
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, 'O_CLOEXEC', 0) | getattr(os, 'O_BINARY', 0)
        self._descriptor = os.open(path, flags, 0o644)
        try:
            self._append([library.MCAP0_MAGIC, _encode(Header(PROFILE, 'goalwire'))])
        except BaseException:
            os.close(self._descriptor)
            raise

    @property
    def size(self) -> int:
        """The number of bytes that were written or wait to be written, without the end."""
        return self._data_end + self._size

    def add_topic(self, topic: Topic) -> None:
        """Register a topic; to be called once, before the topic's first message."""
        key = topic.type_name, topic.schema.text
        schema_id = self._schemas.get(key)
        if schema_id is None:
            schema_id = self._schemas[key] = len(self._schemas) + 1
            schema = SchemaRecord(
                id=schema_id,
                name=topic.type_name,
                encoding=topic.schema.encoding,
                data=topic.schema.text.encode(),
            )
            self._schema_records.append(_encode(schema))
            self._unwritten.append(self._schema_records[-1])
        number = self._channels[topic.name] = len(self._channels) + 1
        channel = Channel(
            id=number,
            topic=topic.name,
            message_encoding=topic.serialization,
            metadata={'offered_qos_profiles': qos_text(topic.qos), 'topic_type_hash': topic.type_hash},
            schema_id=schema_id,
        )
        self._channel_records.append(_encode(channel))
        self._unwritten.append(self._channel_records[-1])

    def write(self, message: Message) -> None:
        """Add a message; raises OSError if a chunk cannot be written: then the whole chunk is lost."""
        topic, time, data, sent, sequence = message
        number = self._channels[topic]
        head = _MESSAGE.pack(5, 22 + len(data), number, sequence & 0xFFFFFFFF, time, sent)
        if not self._parts:
            self._chunk_start = self._chunk_end = time
        elif time < self._chunk_start:
            self._chunk_start = time
        elif time > self._chunk_end:
            self._chunk_end = time
        self._indices[number].append(_INDEX_ENTRY.pack(time, self._size))
        self._parts += (head, data)
        self._size += len(head) + len(data)
        if not self.count:
            self.start = self.end = time
        self.start, self.end = min(self.start, time), max(self.end, time)
        self.count += 1
        if self._size >= self._chunk_bytes:
            self._write_chunk()

    def wants_end(self) -> bool:
        """Tell whether so many bytes were written since the last end that a new end adds little."""
        return self._since_end > _END_SHARE * self._end_size

    def flush(self, metadata: str) -> None:
        """Complete the file: write the waiting messages, and an end with this metadata.

        Raises OSError.
        """
        if self._parts:
            self._write_chunk()
        if not self._has_end or self._unwritten:
            self._write_end(metadata)

    def sync(self) -> None:
        """Have the system write the data to the disk. Callable from any thread, also while the file is being
        closed.
        """
        descriptor = self._descriptor
        if descriptor >= 0:
            with suppress(OSError):
                getattr(os, 'fdatasync', os.fsync)(descriptor)

    def close(self, metadata: str) -> None:
        """Write the end and close the file. Idempotent.

        If the disk has no room for the end, the last chunks are removed to make room, so that the file can be
        read. Raises OSError if even that fails.
        """
        if self._descriptor < 0:
            return
        try:
            if self._parts:
                self._write_chunk()
        except OSError:
            self._close_full(metadata)
            raise
        try:
            self._write_end(metadata)
        except OSError:
            self._close_full(metadata)
            raise
        self._release()

    def _close_full(self, metadata: str) -> None:
        """Close on a full disk: remove chunks, the last one first, until there is room for the end."""
        try:
            while True:
                try:
                    self._write_end(metadata)
                except OSError:
                    if not self._chunks:
                        raise
                    self._give_up_chunk()
                else:
                    return
        finally:
            self._release()

    def _give_up_chunk(self) -> None:
        chunk = self._chunks.pop()
        self._cut(chunk.offset)
        for number, count in chunk.counts.items():
            self._counts[number] -= count
            self.count -= count

    def _release(self) -> None:
        descriptor, self._descriptor = self._descriptor, -1
        os.close(descriptor)

    # -- chunks ----------------------------------------------------------------------------------------------

    def _write_chunk(self) -> None:
        """Write the waiting messages as a chunk, with their index.

        If the writing fails, the whole chunk is lost: no part of it stays in the file.
        """
        parts, size, indices = self._parts, self._size, self._indices
        self._parts, self._size, self._indices = [], 0, defaultdict(list)
        counts = {number: len(entries) for number, entries in indices.items()}
        try:
            self._put_chunk(parts, size, indices, counts)
        except BaseException:
            self.count -= sum(counts.values())
            raise
        for number, count in counts.items():
            self._counts[number] += count

    def _put_chunk(
        self, parts: list[bytes], size: int, indices: dict[int, list[bytes]], counts: dict[int, int]
    ) -> None:
        if len(parts) > _PIECES // 2 or self._compression.compress is not None:
            parts = [b''.join(parts)]
        checksum = 0
        for part in parts:
            checksum = zlib.crc32(part, checksum)
        if self._compression.compress is not None:
            parts = [self._compression.compress(parts[0])]
        stored = sum(map(len, parts))
        name = self._compression.name.encode()
        start, end = self._chunk_start, self._chunk_end
        head = _CHUNK.pack(Opcode.CHUNK, 40 + len(name) + stored, start, end, size, checksum)
        head += struct.pack(f'<I{len(name)}sQ', len(name), name, stored)
        before = self._unwritten
        offset = self._data_end + sum(map(len, before))
        position = offset + len(head) + stored
        offsets, index_parts = {}, []
        for number, entries in indices.items():
            offsets[number] = position
            array = b''.join(entries)
            index_parts.append(_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(array), number, len(array)) + array)
            position += len(index_parts[-1])
        self._append([*before, head, *parts, *index_parts])
        self._unwritten = []
        index = ChunkIndex(
            message_start_time=start,
            message_end_time=end,
            chunk_start_offset=offset,
            chunk_length=len(head) + stored,
            message_index_offsets=offsets,
            message_index_length=sum(map(len, index_parts)),
            compression=self._compression.name,
            compressed_size=stored,
            uncompressed_size=size,
        )
        self._chunks.append(_Chunk(offset, _encode(index), counts))

    # -- the end of the file: summary and footer -------------------------------------------------------------

    def _write_end(self, metadata: str) -> None:
        """Write metadata, summary and footer behind the data; the next chunk overwrites them."""
        record = _encode(Metadata(name=METADATA_NAME, metadata={METADATA_KEY: metadata}))
        before = [*self._unwritten]
        offset = self._data_end + sum(map(len, before))
        before += [record, _encode(DataEnd(0))]
        summary_start = self._data_end + sum(map(len, before))
        groups = [
            (Opcode.SCHEMA, self._schema_records),
            (Opcode.CHANNEL, self._channel_records),
            (Opcode.STATISTICS, [_encode(self._statistics())]),
            (Opcode.CHUNK_INDEX, [chunk.summary for chunk in self._chunks]),
            (
                Opcode.METADATA_INDEX,
                [_encode(MetadataIndex(offset=offset, length=len(record), name=METADATA_NAME))],
            ),
        ]
        summary, offsets, at = [], [], summary_start
        for opcode, records in groups:
            group = b''.join(records)
            if group:
                offsets.append(
                    _encode(SummaryOffset(group_opcode=opcode, group_start=at, group_length=len(group)))
                )
            summary.append(group)
            at += len(group)
        summary += offsets
        checksum = 0
        for part in summary:
            checksum = zlib.crc32(part, checksum)
        checksum = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, summary_start, at), checksum)
        footer = Footer(summary_start=summary_start, summary_offset_start=at, summary_crc=checksum)
        parts = [*before, *summary, _encode(footer), library.MCAP0_MAGIC]
        data_end = self._data_end
        self._append(parts)
        self._end_size, self._since_end = self._data_end - data_end, 0
        self._data_end, self._has_end = data_end, True

    def _statistics(self) -> Statistics:
        filled = {number: count for number, count in self._counts.items() if count}
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channel_records),
            channel_message_counts=filled,
            chunk_count=len(self._chunks),
            message_count=sum(filled.values()),
            metadata_count=1,
            message_start_time=self.start,
            message_end_time=self.end,
            schema_count=len(self._schema_records),
        )

    # -- the file --------------------------------------------------------------------------------------------

    def _append(self, parts: Sequence[bytes]) -> None:
        """Append `parts` to the data; the closing part of the file, if it was written, is cut off first.

        If the writing fails, nothing of `parts` stays in the file.
        """
        if self._has_end:
            self._cut(self._data_end)
        try:
            size = _write_all(self._descriptor, parts)
        except OSError:
            self._cut(self._data_end)
            raise
        self._data_end += size
        self._since_end += size

    def _cut(self, size: int) -> None:
        os.ftruncate(self._descriptor, size)
        os.lseek(self._descriptor, size, os.SEEK_SET)
        self._data_end, self._has_end = size, False


def _encode(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def _write_all(descriptor: int, parts: Iterable[bytes]) -> int:
    """Write all parts to the file.

    Raises OSError. Where the system can write several buffers in one call, large parts are not copied into
    one buffer.
    """
    parts = [part for part in parts if part]
    if len(parts) > _PIECES or not hasattr(os, 'writev'):
        parts = [b''.join(parts)]
    total = sum(map(len, parts))
    views = [memoryview(part) for part in parts]
    while views:
        written = os.writev(descriptor, views) if hasattr(os, 'writev') else os.write(descriptor, views[0])
        while views and written >= len(views[0]):
            written -= len(views.pop(0))
        if views:
            views[0] = views[0][written:]
    return total


def compression(preset: str) -> tuple[Compression, int]:
    """Return the compression and the chunk size of a preset of rosbag2's MCAP storage.

    The presets are 'none', 'fastwrite' (here the same as 'none'), 'zstd_fast' and 'zstd_small'. Raises
    ValueError for another name.
    """
    if preset in {'none', 'fastwrite', ''}:
        return Compression(), CHUNK_BYTES
    levels = {'zstd_fast': 1, 'zstd_small': 19}
    if preset not in levels:
        raise ValueError(f"there is no preset '{preset}': choose none, fastwrite, zstd_fast or zstd_small")
    import zstandard

    compress = zstandard.ZstdCompressor(level=levels[preset]).compress
    return Compression('zstd', compress), 4 * CHUNK_BYTES if preset == 'zstd_small' else CHUNK_BYTES
