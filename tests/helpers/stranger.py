"""A DDS participant that knows nothing of ROS 2's conventions, and sends what it is told to."""

from __future__ import annotations

from ctypes import byref

from goalwire.rules.qos import QoS
from goalwire.transport.dds.cyclone.abi import SERIALIZED_DATA
from goalwire.transport.dds.cyclone.library import load
from goalwire.transport.dds.cyclone.qos import endpoint_qos
from goalwire.transport.dds.cyclone.wire import OutPiece, Participant, Reader, Writer


class Stranger:
    """One participant; `user_data` is what its endpoints say of themselves."""

    def __init__(self, domain_id: int) -> None:
        self.participant = Participant(load(), domain_id, b'')

    def writer(self, topic: str, type_name: str, qos: QoS | None = None, user_data: bytes = b'') -> Writer:
        """Declare a writer."""
        library = self.participant.library
        with endpoint_qos(library, qos or QoS(), user_data) as made:
            return Writer(self.participant, topic, type_name, made)

    def reader(self, topic: str, type_name: str, qos: QoS | None = None, user_data: bytes = b'') -> Reader:
        """Declare a reader."""
        library = self.participant.library
        with endpoint_qos(library, qos or QoS(), user_data) as made:
            return Reader(self.participant, topic, type_name, made)

    def close(self) -> None:
        """Leave the domain."""
        self.participant.close()


def write_unpadded(writer: Writer, payload: bytes) -> bool:
    """Write these bytes and no others; False if the library itself refuses them."""
    library, piece = writer.library, OutPiece(payload, len(payload))
    made = library.ddsi_serdata_from_ser_iov(
        writer.serdata_type, SERIALIZED_DATA, 1, byref(piece), len(payload)
    )
    return bool(made) and library.dds_writecdr(writer.handle, made) == 0
