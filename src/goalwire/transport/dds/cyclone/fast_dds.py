"""Calls servers on Fast DDS, which identify requests in another way than Cyclone DDS (behind a switch).

There a request is the bare message. The writer that sent it stands for the client, and the count of its
messages is the request's number. A reply repeats both in its packet's inline QoS, which Cyclone DDS does not
hand on. So for replies one function of the library is replaced, the one that makes a sample of a packet. It
turns the reply of a Fast DDS server into what a server on Cyclone would have sent. Nothing else changes.

Source: rmw_fastrtps_shared_cpp src/rmw_request.cpp, rmw_response.cpp; DDS-RTPS 2.5, 9.4.5 and 9.6. The
layouts are private to Cyclone DDS 11.0 (ddsi_sertype.h, ddsi_serdata.h, ddsi_radmin.h). A library of another
version is refused, and so is one whose samples do not have the operations that are about to be replaced.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from ctypes import (
    CFUNCTYPE,
    Array,
    addressof,
    byref,
    c_int32,
    c_size_t,
    c_void_p,
    cast,
    create_string_buffer,
    sizeof,
    string_at,
)
from functools import partial
from pathlib import PurePath
from struct import Struct
from threading import Lock
from typing import NamedTuple

from goalwire.errors import TransportError
from goalwire.transport.dds.cyclone.abi import GUID_SIZE, PACKET_START, SERIALIZED_DATA, Library, PacketPiece
from goalwire.transport.dds.cyclone.configuration import FAST_DDS_SERVICES
from goalwire.transport.dds.cyclone.library import INSTALLING
from goalwire.transport.dds.cyclone.wire import OutPiece, Reader, Writer, check
from goalwire.transport.dds.service_header import Header, wrap

_KNOWN_VERSION = re.compile(r'\b11\.0\.\d')
_OPERATIONS_AT = sizeof(c_void_p)
"""Where a sample type keeps its samples' operations (struct ddsi_sertype); a sample has their address at
0."""
_OPERATIONS = 17
_FROM_PACKET = 2
"""Which of a sample type's operations makes a sample of a packet (struct ddsi_serdata_ops)."""
_EMPTY_MESSAGE = b'\0\1\0\0\0\0\0\0'
_FromPacket = CFUNCTYPE(c_void_p, c_void_p, c_int32, c_void_p, c_size_t)
_Table = c_void_p * _OPERATIONS

_DATA, _DATA_FRAGMENT = 0x15, 0x16
_LITTLE_ENDIAN, _HAS_QOS = 0x01, 0x02
_BEFORE_QOS = 8
"""Where a submessage's count of bytes before its inline QoS ends."""
_RELATED = frozenset({0x0083, 0x800F})
"""PID_RELATED_SAMPLE_IDENTITY: the standard's number, and the one Fast DDS had before it."""
_SENTINEL = 1
NOBODY = Header(0, 0)
"""Before a reply to another client: of no client here."""


def related_request(start: bytes) -> tuple[bytes, int] | None:
    """Return whose request a reply answers, a GUID, and its number; None if the packet does not say.

    `start` is the DATA submessage up to its payload. What is not laid out as it should be says nothing.
    """
    if len(start) < _BEFORE_QOS or start[0] not in {_DATA, _DATA_FRAGMENT} or not start[1] & _HAS_QOS:
        return None
    order = '<' if start[1] & _LITTLE_ENDIAN else '>'
    parameter, number = Struct(f'{order}HH'), Struct(f'{order}iI')
    at = _BEFORE_QOS + int.from_bytes(start[6:8], 'little' if order == '<' else 'big')
    found = None
    while at + parameter.size <= len(start):
        kind, size = parameter.unpack_from(start, at)
        at += parameter.size
        if kind == _SENTINEL:
            return found
        if kind in _RELATED and size >= GUID_SIZE + number.size and at + size <= len(start):
            high, low = number.unpack_from(start, at + GUID_SIZE)
            found = start[at : at + GUID_SIZE], (high << 32) + low
        at += size
    return None


class Calls:
    """One client's requests to servers on Fast DDS, by the numbers that their writer gives them."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._lock = Lock()
        self._written = 0
        self._sequences: dict[int, int] = {}
        self._numbers: dict[int, int] = {}

    def write(self, payload: bytes, sequence: int | None = None) -> int:
        """Send and count one message of the client; with a sequence number it is a request to Fast DDS."""
        with self._lock:
            number = self._written + 1
            if sequence is not None:
                self._sequences[number] = sequence
                self._numbers[sequence] = number
            result = self._writer.write(payload)
            if not result:
                self._written = number
        if result and sequence is not None:
            self.end(sequence)
        return result

    def header(self, number: int) -> Header:
        """Return what a Cyclone server would have put before its reply to that message."""
        sequence = self._sequences.get(number)
        return NOBODY if sequence is None else Header(self._writer.instance, sequence)

    def end(self, sequence: int) -> None:
        """Nobody waits for replies to this request any more."""
        with self._lock:
            self._sequences.pop(self._numbers.pop(sequence, 0), None)


class Replaced(NamedTuple):
    """A table of operations of ours, and the function in it that is not the library's."""

    table: Array[c_void_p]
    translating: object


class Translation:
    """Makes Cyclone's replies of those of Fast DDS, on the library's receiving thread."""

    def __init__(self, library: Library) -> None:
        """Raises TransportError for a library whose layouts are not known."""
        if not _KNOWN_VERSION.search(PurePath(library.path).name) or library.dds_get_entity_sertype is None:
            raise TransportError(
                f"{FAST_DDS_SERVICES}=1 needs Cyclone DDS 11.0, which '{library.path}' does not say it is: "
                f'{INSTALLING}, or unset {FAST_DDS_SERVICES}'
            )
        self._library = library
        self._sample_type_of = library.dds_get_entity_sertype
        self._lock = Lock()
        self._clients: dict[bytes, Calls] = {}
        self._tables: dict[int, Replaced] = {}
        """By the address of the library's operations, and by that of ours, so that those are replaced once.

        The library calls and reads them: they live as long as the process.
        """

    def add(self, writer: Writer, reader: Reader) -> Calls:
        """Have the replies translated that a client's reader gets.

        Raises TransportError if the library's operations are not where they are looked for.
        """
        found = c_void_p()
        check(self._library, self._sample_type_of(reader.handle, byref(found)), reader.topic)
        sample_type = found.value or 0
        operations = c_void_p.from_address(sample_type + _OPERATIONS_AT)
        with self._lock:
            if operations.value != self._operations_of_a_sample(sample_type):
                raise TransportError(
                    f"{FAST_DDS_SERVICES}=1: '{self._library.path}' is laid out differently from Cyclone DDS "
                    f'11.0: {INSTALLING}, or unset {FAST_DDS_SERVICES}'
                )
            operations.value = addressof(self._replaced(operations.value or 0).table)
        calls = self._clients[writer.guid] = Calls(writer)
        return calls

    def remove(self, writer: Writer) -> None:
        """A client is going."""
        self._clients.pop(writer.guid, None)

    def _operations_of_a_sample(self, sample_type: int) -> int | None:
        """Return which operations a new sample of the type has."""
        piece = OutPiece(_EMPTY_MESSAGE, len(_EMPTY_MESSAGE))
        sample = self._library.ddsi_serdata_from_ser_iov(
            sample_type, SERIALIZED_DATA, 1, byref(piece), len(_EMPTY_MESSAGE)
        )
        if not sample:
            return None
        try:
            return c_void_p.from_address(sample).value
        finally:
            self._library.ddsi_serdata_unref(sample)

    def _replaced(self, operations: int) -> Replaced:
        """Return a table of operations that translates; one for each of the library's."""
        replaced = self._tables.get(operations)
        if replaced is None:
            table = _Table.from_buffer_copy(_Table.from_address(operations))
            original = _FromPacket(table[_FROM_PACKET] or 0)
            translating = _FromPacket(partial(self._from_packet, original))
            table[_FROM_PACKET] = cast(translating, c_void_p).value
            replaced = self._tables[operations] = self._tables[addressof(table)] = Replaced(
                table, translating
            )
        return replaced

    def _from_packet(
        self, original: Callable[..., int], sample_type: int, kind: int, packet: int, size: int
    ) -> int:
        made = original(sample_type, kind, packet, size)
        if not made or kind != SERIALIZED_DATA:
            return made
        related = related_request(_start_of(packet))
        if related is None:
            return made
        guid, number = related
        calls = self._clients.get(guid)
        try:
            return self._with_header(sample_type, NOBODY if calls is None else calls.header(number), made)
        finally:
            self._library.ddsi_serdata_unref(made)

    def _with_header(self, sample_type: int, header: Header, sample: int) -> int:
        size = self._library.ddsi_serdata_size(sample)
        content = create_string_buffer(size)
        self._library.ddsi_serdata_to_ser(sample, 0, size, content)
        reply = wrap(header, content.raw)
        piece = OutPiece(reply, len(reply))
        return self._library.ddsi_serdata_from_ser_iov(
            sample_type, SERIALIZED_DATA, 1, byref(piece), len(reply)
        )


def _start_of(packet: int) -> bytes:
    """Return the submessage of a sample's first fragment, up to its payload."""
    piece = PacketPiece.from_address(packet)
    received = (piece.packet or 0) + PACKET_START
    return string_at(received + piece.submessage, piece.payload - piece.submessage)


_made: list[Translation] = []
_making = Lock()


def translation(library: Library) -> Translation:
    """Return the process' one translation; raises TransportError if the library does not allow it."""
    with _making:
        if not _made:
            _made.append(Translation(library))
        return _made[0]
