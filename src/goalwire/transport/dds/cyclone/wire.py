"""Participants, writers and readers of raw CDR: thin wrappers of the library's handles.

A topic is declared as one octet and without type information. The library then validates only the first byte,
so any message passes unchanged, and discovery looks as rmw_cyclonedds' does.
"""

from __future__ import annotations

import ctypes
import struct
import threading
from collections.abc import Callable
from contextlib import ExitStack
from ctypes import addressof, byref, c_char, c_uint32, c_uint64, c_void_p, sizeof, string_at
from functools import cache, partial
from typing import NamedTuple

from goalwire.errors import LocalError, TransportError
from goalwire.transport.dds.cyclone.abi import (
    ANY_STATE,
    SERIALIZED_DATA,
    Guid,
    Library,
    Piece,
    SampleInfo,
    TopicDescriptor,
)

BATCH = 32
"""The number of samples taken from a reader at once."""
LARGE = 65_536
"""Messages of this many bytes or more are copied without the GIL, so that other threads run."""

SMALL = 1024
"""Messages of up to this many bytes are copied out by way of a buffer, which saves two calls."""

_RESTRICTS_REPRESENTATION = 0x80
_XCDR1 = 1
_ONE_OCTET = (c_uint32 * 3)(0x01010000, 0, 0)
_PADDING = b'\0\0\0'
_INFO_SIZE = sizeof(SampleInfo)


class OutPiece(ctypes.Structure):
    """An abi.Piece that points into a bytes object, and keeps it alive."""

    _fields_ = [(field[0], ctypes.c_char_p if field[0] == 'base' else field[1]) for field in Piece._fields_]


class RawSample(NamedTuple):
    """One message as it came out of a reader; its time is in ns since the UNIX epoch."""

    payload: bytes
    source_timestamp: int
    publication: int
    """The instance handle of the message's writer."""


class _Scratch:
    """The buffers, with their addresses, in which one thread takes samples and makes small ones."""

    __slots__ = ('infos', 'infos_address', 'out', 'out_address', 'room', 'samples', 'samples_address')

    def __init__(self) -> None:
        self.samples = (c_void_p * BATCH)()
        self.infos = (SampleInfo * BATCH)()
        self.samples_address, self.infos_address = addressof(self.samples), addressof(self.infos)
        self.room = (c_char * SMALL)()
        self.out = OutPiece()
        self.out_address = addressof(self.out)


class _Threads(threading.local):
    """Buffers, one set for each thread."""

    def __init__(self) -> None:
        self.scratch = _Scratch()


_here = _Threads()
_new_raw_sample: Callable[[tuple[bytes, int, int]], RawSample] = partial(tuple.__new__, RawSample)
"""Makes a RawSample by tuple.__new__, which runs no Python code."""
_read_info = struct.Struct('=12x?3xq8xQ').unpack_from
"""Reads three fields of dds_sample_info_t: valid_data, source_timestamp, publication_handle."""


def check(library: Library, result: int, what: str) -> int:
    """Return `result`, a handle or a count; raise TransportError if it is an error code."""
    if result < 0:
        raise TransportError(f'{what}: Cyclone DDS says: {library.dds_strretcode(result).decode()}')
    return result


def guid_of(library: Library, entity: int) -> bytes:
    """Return the 16 bytes that name an entity on the wire."""
    guid = Guid()
    check(library, library.dds_get_guid(entity, byref(guid)), 'guid')
    return bytes(guid)


@cache
def _descriptor(type_name: str) -> TopicDescriptor:
    return TopicDescriptor(
        size=1,
        align=1,
        flags=_RESTRICTS_REPRESENTATION,
        type_name=type_name.encode(),
        op_count=2,
        ops=_ONE_OCTET,
        meta=b'',
        representations=_XCDR1,
    )


class Participant:
    """The DDS participant of a session."""

    def __init__(self, library: Library, domain_id: int, user_data: bytes) -> None:
        self.library = library
        qos = library.dds_create_qos()
        library.dds_qset_userdata(qos, user_data, len(user_data))
        try:
            self.handle = library.dds_create_participant(domain_id, qos, None)
        finally:
            library.dds_delete_qos(qos)
        check(
            library,
            self.handle,
            f'cannot join domain {domain_id} (it has written why to standard error; check that the network '
            f'interface is up, CYCLONEDDS_URI, and how many programs share the domain on this machine)',
        )
        self.guid = guid_of(library, self.handle)
        self.leaving = False
        """True once the participant is about to be deleted with all its entities: then no entity is deleted
        alone."""

    def leave_at_once(self) -> None:
        """Stop deleting single entities: the participant is about to be deleted with all of them."""
        self.leaving = True

    def topic(self, name: str, type_name: str) -> int:
        """Declare a topic and return its handle. The caller deletes it once the reader or writer exists."""
        made = self.library.dds_create_topic(self.handle, _descriptor(type_name), name.encode(), None, None)
        return check(self.library, made, f"topic '{name}' of type {type_name}")

    def close(self) -> None:
        """Delete the participant with all its entities."""
        self.library.dds_delete(self.handle)


class Writer:
    """A writer of the library."""

    def __init__(self, participant: Participant, topic: str, type_name: str, qos: int) -> None:
        self.library = library = participant.library
        self._participant = participant
        self.topic = topic
        declared = participant.topic(topic, type_name)
        try:
            self.handle = library.dds_create_writer(participant.handle, declared, qos, None)
            check(library, self.handle, f"writer of '{topic}'")
            self.serdata_type = _serdata_type(participant, self.handle, topic, type_name)
            self._make, self._send = library.ddsi_serdata_from_ser_iov, library.dds_writecdr
        finally:
            library.dds_delete(declared)
        self.guid = guid_of(library, self.handle)
        instance = c_uint64()
        library.dds_get_instance_handle(self.handle, byref(instance))
        self.instance = instance.value

    def write(self, payload: bytes) -> int:
        """Send one message; return 0 or the library's error, TIMEOUT if there was no room in time.

        Raises LocalError for bytes that are not a message.
        """
        size = len(payload)
        if size <= SMALL:
            if size & 3:  # padded to a multiple of four, which the network layer relies on
                payload += _PADDING[: -size & 3]
                size = len(payload)
            scratch = _here.scratch
            piece = scratch.out
            piece.base, piece.size = payload, size
            made = self._make(self.serdata_type, SERIALIZED_DATA, 1, scratch.out_address, size)
        else:
            made = self._large(payload, size)
        if not made:
            raise LocalError(
                f"topic '{self.topic}': {size} bytes that begin with {payload[:4].hex() or 'nothing'} are no "
                f'serialized message, which begins with 00010000 and has 5 bytes or more'
            )
        return self._send(self.handle, made)

    def _large(self, payload: bytes, size: int) -> int:
        """Make a sample from the payload without copying it first."""
        padding = -size & 3
        pieces = (OutPiece * 2)(OutPiece(payload, size), OutPiece(_PADDING, padding))
        make, count = self._make if size < LARGE else self.library.from_large, 2 if padding else 1
        return make(self.serdata_type, SERIALIZED_DATA, count, addressof(pieces), size + padding)

    def delete(self) -> None:
        """Delete the writer, which takes it off the wire."""
        if not self._participant.leaving:
            self.library.dds_delete(self.handle)


def _serdata_type(participant: Participant, writer: int, topic: str, type_name: str) -> int:
    """Return the library's own handle of a topic's type; serialized messages are made with it."""
    found = c_void_p()
    get = participant.library.dds_get_entity_sertype
    if get is not None:
        check(participant.library, get(writer, byref(found)), f"type of '{topic}'")
        return found.value or 0
    return _type_inside_a_sample(participant, type_name)


class Reader:
    """One reader, and the condition that is true while it has something to take."""

    def __init__(self, participant: Participant, topic: str, type_name: str, qos: int) -> None:
        self.library = library = participant.library
        self._participant = participant
        self.topic = topic
        declared = participant.topic(topic, type_name)
        try:
            self.handle = library.dds_create_reader(participant.handle, declared, qos, None)
        finally:
            library.dds_delete(declared)
        check(library, self.handle, f"reader of '{topic}'")
        self._take = library.dds_takecdr
        self.at_once = BATCH
        """How many samples are taken at once. Large ones are taken one by one: while they wait in the library
        they need no copy."""
        self.condition = library.dds_create_readcondition(self.handle, ANY_STATE)
        self.guid = guid_of(library, self.handle)

    def take(self) -> tuple[int, list[RawSample]]:
        """Take up to `at_once` samples; return how many there were, and the messages among them."""
        scratch = _here.scratch
        count = self._take(
            self.handle, scratch.samples_address, self.at_once, scratch.infos_address, ANY_STATE
        )
        taken: list[RawSample] = []
        size = 0
        library, samples, infos, room = self.library, scratch.samples, scratch.infos, scratch.room
        for index in range(count):
            sample = samples[index] or 0
            valid, sent, publication = _read_info(infos, index * _INFO_SIZE)
            if valid:
                size = library.ddsi_serdata_size(sample)
                if size <= SMALL:
                    library.ddsi_serdata_to_ser(sample, 0, size, room)
                    payload: bytes = room[:size]  # type: ignore[assignment]
                else:
                    payload = _large_content(library, sample, size)
                taken.append(_new_raw_sample((payload, sent, publication)))
            library.ddsi_serdata_unref(sample)
        if taken:
            self.at_once = BATCH if size < LARGE else 1
        return count, taken

    def delete(self) -> None:
        """Delete the reader, which takes it off the wire."""
        if not self._participant.leaving:
            self.library.dds_delete(self.handle)


def _large_content(library: Library, sample: int, size: int) -> bytes:
    """Return a sample's bytes, encapsulation first."""
    piece = Piece()
    held = library.ddsi_serdata_to_ser_ref(sample, 0, size, byref(piece))
    content = string_at(piece.base, size)
    library.ddsi_serdata_to_ser_unref(held, byref(piece))
    return content


_PARTITION = b'goalwire_type_inside'
_TYPE_TOPIC = 'goalwire_type_inside'
_TYPE_OFFSET = 24
"""The offset of the pointer to the type in a serialized sample (struct ddsi_serdata)."""


def _type_inside_a_sample(participant: Participant, type_name: str) -> int:
    """Return the library's own handle of a type for libddsc 0.10 (ROS 2 Humble to Kilted).

    A sample of the type holds the handle, which all topics of the type share. So a sample is written and read
    on a topic and in a partition of their own: nobody else sees it or reports its QoS as incompatible.
    """
    library, parent = participant.library, participant.handle
    with ExitStack() as undo:
        topic = participant.topic(_TYPE_TOPIC, type_name)
        undo.callback(library.dds_delete, topic)
        qos = library.dds_create_qos()
        undo.callback(library.dds_delete_qos, qos)
        library.dds_qset_partition1(qos, _PARTITION)
        publisher = check(library, library.dds_create_publisher(parent, qos, None), 'publisher')
        undo.callback(library.dds_delete, publisher)
        subscriber = check(library, library.dds_create_subscriber(parent, qos, None), 'subscriber')
        undo.callback(library.dds_delete, subscriber)
        reader = check(library, library.dds_create_reader(subscriber, topic, None, None), 'reader')
        writer = check(library, library.dds_create_writer(publisher, topic, None, None), 'writer')
        check(library, library.dds_write(writer, b'\0'), 'write')
        samples, infos = (c_void_p * 1)(), (SampleInfo * 1)()
        if library.dds_takecdr(reader, samples, 1, infos, ANY_STATE) != 1 or not samples[0]:
            check(library, -1, 'a sample of its own')
        sample = samples[0] or 0
        try:
            return c_void_p.from_address(sample + _TYPE_OFFSET).value or 0
        finally:
            library.ddsi_serdata_unref(sample)
