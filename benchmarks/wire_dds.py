"""libddsc alone, with goalwire's domain configuration and none of its threads: an end of the floor on DDS.

It waits in a waitset of its own on its only thread and takes what is there, decoding nothing.
It is in the domain that ROS_DOMAIN_ID names.
"""

from __future__ import annotations

import os
import sys
from ctypes import byref, c_ssize_t, c_uint32, c_uint64, c_void_p, string_at

from goalwire.rules.qos import HistoryPolicy, QoS
from goalwire.transport.dds.cyclone.abi import ANY_STATE, SERIALIZED_DATA, Library, Piece, SampleInfo
from goalwire.transport.dds.cyclone.configuration import domain_configuration
from goalwire.transport.dds.cyclone.library import find_library
from goalwire.transport.dds.cyclone.qos import endpoint_qos
from goalwire.transport.dds.cyclone.status import PUBLICATION_MATCHED, SUBSCRIPTION_MATCHED
from goalwire.transport.dds.cyclone.wire import OutPiece, Participant, Reader, Writer

PATIENCE_NS = 20_000_000_000
_TYPE = 'goalwire::msg::dds_::Raw_'
_AT_ONCE = 32


class End:
    """A participant that writes one topic and reads another."""

    def __init__(self, writes: str, reads: str) -> None:
        self.library = library = Library(find_library())
        domain_id = int(os.environ.get('ROS_DOMAIN_ID', '0'))
        self._domain = library.dds_create_domain(domain_id, domain_configuration(domain_id).encode())
        self._participant = participant = Participant(library, domain_id, b'')
        with endpoint_qos(library, QoS(history=HistoryPolicy.KEEP_ALL), b'') as qos:
            self.writer = Writer(participant, writes, _TYPE, qos)
            self.reader = Reader(participant, reads, _TYPE, qos)
        self._type = self.writer.serdata_type
        self._waitset = library.dds_create_waitset(participant.handle)
        library.dds_waitset_attach(self._waitset, self.reader.condition, 1)
        self._samples, self._infos = (c_void_p * _AT_ONCE)(), (SampleInfo * _AT_ONCE)()
        self._triggered, self._piece = (c_ssize_t * 1)(), Piece()

    def meet(self) -> None:
        """Wait until somebody reads what this writes, and writes what this reads."""
        library = self.library
        for entity, status, matched in (
            (self.writer.handle, PUBLICATION_MATCHED, library.dds_get_matched_subscriptions),
            (self.reader.handle, SUBSCRIPTION_MATCHED, library.dds_get_matched_publications),
        ):
            library.dds_set_status_mask(entity, status)
            waitset = library.dds_create_waitset(self._participant.handle)
            library.dds_waitset_attach(waitset, entity, 1)
            while matched(entity, (c_uint64 * 1)(), 1) < 1:
                if library.dds_waitset_wait(waitset, self._triggered, 1, PATIENCE_NS) <= 0:
                    sys.exit('the other end was not found')
                library.dds_take_status(entity, byref(c_uint32()), status)
            library.dds_delete(waitset)

    def write(self, message: bytes) -> None:
        """Send one message; its length is a multiple of four."""
        library, size = self.library, len(message)
        made = library.ddsi_serdata_from_ser_iov(
            self._type, SERIALIZED_DATA, 1, byref(OutPiece(message, size)), size
        )
        library.dds_writecdr(self.writer.handle, made)

    def take(self, patience_ns: int) -> list[bytes]:
        """Wait for messages and take up to 32; none if they take too long."""
        library = self.library
        if library.dds_waitset_wait(self._waitset, self._triggered, 1, patience_ns) <= 0:
            return []
        count = library.dds_takecdr(self.reader.handle, self._samples, _AT_ONCE, self._infos, ANY_STATE)
        return [self._content(self._samples[index] or 0, self._infos[index]) for index in range(count)]

    def _content(self, sample: int, info: SampleInfo) -> bytes:
        library, piece, content = self.library, self._piece, b''
        if info.valid_data:
            size = library.ddsi_serdata_size(sample)
            held = library.ddsi_serdata_to_ser_ref(sample, 0, size, byref(piece))
            content = string_at(piece.base, size)
            library.ddsi_serdata_to_ser_unref(held, byref(piece))
        library.ddsi_serdata_unref(sample)
        return content

    def close(self) -> None:
        """Leave the domain."""
        self.library.dds_delete(self._domain)
