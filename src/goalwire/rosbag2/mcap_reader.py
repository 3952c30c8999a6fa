"""Reads one MCAP file, whole or cut off.

A whole file ends with a summary that names its chunks. Without a summary the whole file is read once to find
the chunks: so a file that a dying process or a full disk has cut off can be read as far as it goes.
"""

from __future__ import annotations

import heapq
import os
import struct
from collections import Counter
from collections.abc import Collection, Iterator
from io import BytesIO
from typing import TYPE_CHECKING, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, Metadata, Statistics
from mcap.records import Schema as SchemaRecord
from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

from goalwire.errors import BagError
from goalwire.files import show
from goalwire.rosbag2.mcap_writer import METADATA_KEY, METADATA_NAME
from goalwire.rosbag2.metadata import qos_of_text
from goalwire.rosbag2.model import Message, Schema, Topic

if TYPE_CHECKING:
    from typing import BinaryIO, Self

    from mcap.summary import Summary

_MAGIC = b'\x89MCAP0\r\n'
_HEAD = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_RUN_BYTES = 2**22
"""Messages outside of chunks are read in groups of about this size, in bytes."""
LARGEST_RECORD = 2**32
_BROKEN = (
    McapError,
    CRCValidationError,
    struct.error,
    ValueError,
    KeyError,
    EOFError,
    RuntimeError,
    MemoryError,
    OverflowError,
)
"""The errors that the mcap library and the decompressors raise for broken bytes, the last two for lengths."""


class Span(NamedTuple):
    """A part of the file with messages: a chunk, or a group of messages outside of chunks."""

    start: int
    end: int
    """The times of the span's earliest and latest message, in ns."""
    offset: int
    length: int
    channels: frozenset[int] | None
    """The channels of the span's messages; None if the file does not list them."""


class McapReader:
    """Reads a file; a context manager. Only one thread may use it."""

    storage = 'mcap'

    def __init__(self, path: str) -> None:
        """Open the file; raises OSError, BagError."""
        self.path = path
        self.problem = ''
        """The reason why the file is not whole; '' for a whole file."""
        self._forget()
        self._file: BinaryIO = open(path, 'rb')  # noqa: SIM115 - it is open as long as this is
        try:
            self._size = os.fstat(self._file.fileno()).st_size
            self._read_magic()
            if not self._read_summary():
                self._scan()
            self._spans.sort(key=lambda span: (span.start, span.offset))
        except BaseException:
            self._file.close()
            raise

    @property
    def count(self) -> int:
        """How many messages the file has."""
        return self.counts.total()

    # -- finding the chunks and messages ---------------------------------------------------------------------

    def _read_magic(self) -> None:
        if self._file.read(len(_MAGIC)) != _MAGIC:
            raise BagError(f'{show(self.path)}: it is not an MCAP file, or its first bytes are lost')

    def _read_summary(self) -> bool:
        """Read the file's summary; False if it is missing, incomplete or broken."""
        try:
            self._file.seek(-len(_MAGIC), os.SEEK_END)
            if self._file.read() != _MAGIC:
                self.problem = 'it has no end: whoever wrote it did not close it'
                return False
            self._file.seek(0)
            summary = SeekingReader(self._file).get_summary()
            return summary is not None and self._take_summary(summary)
        except (*_BROKEN, OSError) as error:
            self._forget()
            self.problem = f'its summary is broken ({error})'
            return False

    def _take_summary(self, summary: Summary) -> bool:
        """Take what the summary says; False if it does not say where the messages are.

        Raises an error of `_BROKEN` if its parts do not fit together. That happens to whole files, too: a
        recorder that runs replaces the end of its file, and may do so between two reads here.
        """
        statistics = summary.statistics
        if statistics is None or not statistics.chunk_count:
            return statistics is not None and self._take_empty(statistics)
        if len(summary.chunk_indexes) != statistics.chunk_count or not summary.channels:
            return False
        self._schemas.update(summary.schemas)
        for channel in summary.channels.values():
            self._add_channel(channel)
        for number, count in statistics.channel_message_counts.items():
            self.counts[self._names[number]] += count
        self.start = statistics.message_start_time
        self.end = statistics.message_end_time
        for index in summary.chunk_indexes:
            channels = frozenset(index.message_index_offsets) or None
            self._spans.append(
                Span(
                    index.message_start_time,
                    index.message_end_time,
                    index.chunk_start_offset,
                    index.chunk_length,
                    channels,
                )
            )
        for metadata in summary.metadata_indexes:
            if metadata.name == METADATA_NAME:
                self._take_metadata(self._at(metadata.offset, metadata.length))
        return True

    def _forget(self) -> None:
        """Begin with nothing known. A scan that follows a broken summary so counts nothing twice."""
        self.metadata = ''
        """The bag's metadata in the file; '' if the file has none."""
        self.topics: list[Topic] = []
        self.counts: Counter[str] = Counter()
        self.start = self.end = 0
        self._names: dict[int, str] = {}
        self._spans: list[Span] = []
        self._schemas: dict[int, SchemaRecord] = {}

    def _take_empty(self, statistics: Statistics) -> bool:
        """Return True if the file has no messages at all, so that it need not be scanned."""
        return statistics.message_count == 0 and statistics.channel_count == 0

    def _scan(self) -> None:
        """Find chunks and messages by reading the whole file. All data after a broken record is lost."""
        offset = len(_MAGIC)
        run = _Run()
        while offset < self._size:
            self._file.seek(offset)
            head = self._file.read(_HEAD.size)
            if len(head) < _HEAD.size:
                self._note('it stops within a record', offset)
                break
            opcode, length = _HEAD.unpack(head)
            end = offset + _HEAD.size + length
            if end > self._size or length > LARGEST_RECORD:
                self._note('it stops within a record', offset)
                break
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                break
            try:
                self._take_record(opcode, offset, length, run)
            except _BROKEN as error:
                self._note(f'a record is broken ({error})', offset)
            offset = end
        self._spans += run.spans()
        filled = [span for span in self._spans if span.end or span.start]
        if filled:
            self.start = min(span.start for span in filled)
            self.end = max(span.end for span in filled)

    def _note(self, what: str, offset: int) -> None:
        self.problem = self.problem or f'{what} at byte {offset:,}'

    def _take_record(self, opcode: int, offset: int, length: int, run: _Run) -> None:
        if opcode == Opcode.MESSAGE:
            number, _, time, _ = _MESSAGE.unpack(self._file.read(_MESSAGE.size))
            self.counts[self._names[number]] += 1
            run.add(time, offset, _HEAD.size + length)
            return
        if opcode not in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.CHUNK, Opcode.METADATA):
            return
        body = self._file.read(length)
        stream = ReadDataStream(BytesIO(body))
        if opcode == Opcode.SCHEMA:
            self._add_schema(SchemaRecord.read(stream))
        elif opcode == Opcode.CHANNEL:
            self._add_channel(Channel.read(stream))
        elif opcode == Opcode.METADATA:
            self._take_metadata(_HEAD.pack(opcode, length) + body)
        else:
            self._take_chunk(Chunk.read(stream), offset, _HEAD.size + length)

    def _take_chunk(self, chunk: Chunk, offset: int, length: int) -> None:
        found: Counter[int] = Counter()
        for opcode, body in _records(_content(chunk)):
            if opcode == Opcode.MESSAGE:
                found[_MESSAGE.unpack_from(body)[0]] += 1
            elif opcode == Opcode.SCHEMA:
                self._add_schema(SchemaRecord.read(ReadDataStream(BytesIO(body))))
            elif opcode == Opcode.CHANNEL:
                self._add_channel(Channel.read(ReadDataStream(BytesIO(body))))
        for number, count in found.items():
            self.counts[self._names[number]] += count
        self._spans.append(
            Span(chunk.message_start_time, chunk.message_end_time, offset, length, frozenset(found))
        )

    def _add_schema(self, schema: SchemaRecord) -> None:
        self._schemas.setdefault(schema.id, schema)

    def _add_channel(self, channel: Channel) -> None:
        if channel.id in self._names:
            return
        self._names[channel.id] = channel.topic
        if any(topic.name == channel.topic for topic in self.topics):
            return
        schema = self._schemas.get(channel.schema_id)
        self.topics.append(
            Topic(
                channel.topic,
                schema.name if schema else '',
                channel.metadata.get('topic_type_hash', ''),
                qos_of_text(channel.metadata.get('offered_qos_profiles', '')),
                Schema(schema.encoding, schema.data.decode('utf-8', 'replace')) if schema else Schema(),
                channel.message_encoding,
            )
        )

    def _take_metadata(self, record: bytes) -> None:
        metadata = Metadata.read(ReadDataStream(BytesIO(record[_HEAD.size :])))
        if metadata.name == METADATA_NAME:
            self.metadata = metadata.metadata.get(METADATA_KEY, '')

    # -- messages --------------------------------------------------------------------------------------------

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, stop: int | None = None
    ) -> Iterator[Message]:
        """Yield messages in the order of their times, and messages with equal times in the order of the file.

        Yields only messages of `topics`, if given, and only from `start` to before `stop` (in ns). Raises
        BagError.
        """
        wanted = frozenset(n for n, name in self._names.items() if topics is None or name in topics)
        waiting: list[tuple[int, int, int, Message]] = []
        for span in self._spans:
            if not _is_wanted(span, wanted, start, stop):
                continue
            while waiting and waiting[0][0] < span.start:
                yield heapq.heappop(waiting)[3]
            for position, (number, message) in enumerate(self._messages_of(span)):
                time = message.time
                if number not in wanted or (start is not None and time < start):
                    continue
                if stop is None or time < stop:
                    heapq.heappush(waiting, (time, span.offset, position, message))
        while waiting:
            yield heapq.heappop(waiting)[3]

    def _messages_of(self, span: Span) -> Iterator[tuple[int, Message]]:
        try:
            yield from self._decode(self._at(span.offset, span.length))
        except _BROKEN as error:
            raise BagError(
                f'{show(self.path)}: the bytes from {span.offset:,} on are broken ({error}); '
                f'see: ros2 bag check, ros2 bag repair'
            ) from error

    def _decode(self, data: bytes) -> Iterator[tuple[int, Message]]:
        names = self._names
        for opcode, body in _records(memoryview(data)):
            if opcode == Opcode.CHUNK:
                content = _content(Chunk.read(ReadDataStream(BytesIO(body))))
            elif opcode == Opcode.MESSAGE:
                content = memoryview(data)
            else:
                continue
            for inner, part in _records(content):
                if inner == Opcode.MESSAGE:
                    number, sequence, time, sent = _MESSAGE.unpack_from(part)
                    payload = bytes(part[_MESSAGE.size :])
                    yield number, Message(names[number], time, payload, sent, sequence)
            if opcode == Opcode.MESSAGE:
                return  # a group of messages outside of chunks: all of them were in `content`

    def check(self) -> Iterator[str]:
        """Read every byte of the file, and yield a text for each fault."""
        if self.problem:
            yield self.problem
        found: Counter[str] = Counter()
        for span in self._spans:
            try:
                for _, message in self._messages_of(span):
                    found[message.topic] += 1
            except BagError as error:
                yield str(error).removeprefix(f'{show(self.path)}: ').partition('; see:')[0]
        for topic in self.topics:
            if found[topic.name] != self.counts[topic.name]:
                told = self.counts[topic.name]
                yield f"'{topic.name}' has {found[topic.name]:,} messages, and the summary tells of {told:,}"

    def rescued(self) -> Iterator[Message]:
        """Yield every readable message, in the order of time; broken parts are left out."""
        self._spans = [span for span in self._spans if self._is_whole(span)]
        yield from self.messages()

    def _is_whole(self, span: Span) -> bool:
        try:
            for _ in self._messages_of(span):
                pass
        except BagError:
            return False
        return True

    def _at(self, offset: int, length: int) -> bytes:
        """Return a part of the file; raises ValueError if the file, which may have grown, ends before it."""
        if offset + length > os.fstat(self._file.fileno()).st_size:
            raise ValueError('they are said to go on beyond the end of the file')
        self._file.seek(offset)
        return self._file.read(length)

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


class _Run:
    """Collects messages outside of chunks into spans of about `_RUN_BYTES`."""

    def __init__(self) -> None:
        self._spans: list[Span] = []
        self._open: Span | None = None

    def add(self, time: int, offset: int, length: int) -> None:
        """Add a message record to the index."""
        last = self._open
        if last is not None and last.offset + last.length == offset and last.length < _RUN_BYTES:
            self._open = Span(
                min(last.start, time), max(last.end, time), last.offset, last.length + length, None
            )
            return
        self.spans()
        self._open = Span(time, time, offset, length, None)

    def spans(self) -> list[Span]:
        """Return the spans of all messages that were added so far."""
        if self._open is not None:
            self._spans.append(self._open)
            self._open = None
        return self._spans


def _is_wanted(span: Span, channels: frozenset[int], start: int | None, stop: int | None) -> bool:
    if start is not None and span.end < start:
        return False
    if stop is not None and span.start >= stop:
        return False
    return span.channels is None or bool(span.channels & channels)


def _content(chunk: Chunk) -> memoryview:
    """Return the content of a chunk, unpacked; raises an error of `_BROKEN` if its checksum is wrong."""
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    except Exception as error:
        if isinstance(error, _BROKEN):
            raise
        raise ValueError(str(error)) from error  # decompressors raise classes of their own
    return memoryview(stream.read(length) if length else b'')


def _records(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield opcode and body of each record; raises ValueError if a record is longer than `data`."""
    at, size = 0, len(data)
    while at < size:
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        if at + length > size:
            raise ValueError('a record is longer than what holds it')
        yield opcode, data[at : at + length]
        at += length
