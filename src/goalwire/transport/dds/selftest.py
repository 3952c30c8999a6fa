"""Holds a loaded library to abi.py before anything is entrusted to it.

Three messages make the way from a writer to a reader in a domain of their own, which sends nothing.
"""

from __future__ import annotations

import time

from goalwire.errors import GoalwireError
from goalwire.rules.qos import QoS
from goalwire.transport.dds.abi import Library
from goalwire.transport.dds.qos import endpoint_qos, read_qos, read_user_data
from goalwire.transport.dds.wire import Participant, Reader, Writer

_DOMAIN = 100
_CONFIGURATION = (
    b'<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
    b'<AllowMulticast>false</AllowMulticast></General><Discovery>'
    b'<ParticipantIndex>none</ParticipantIndex><Tag>goalwire_selftest</Tag></Discovery></Domain></CycloneDDS>'
)
_MESSAGES = (b'\0\1\0\0\7', b'\0\1\0\0self', b'\0\1\0\0' + bytes(range(250)))
_USER_DATA = b'typehash=none;'
_CLOCK_NS = 60_000_000_000


def find_fault(library: Library) -> str:
    """Return what is wrong with a library, '' where nothing is."""
    domain = library.dds_create_domain(_DOMAIN, _CONFIGURATION)
    if domain < 0:
        return 'it cannot create a domain'
    try:
        return _exchange(library)
    except GoalwireError as error:
        return str(error)
    finally:
        library.dds_delete(domain)


def _exchange(library: Library) -> str:
    participant = Participant(library, _DOMAIN, b'')
    asked = QoS(depth=len(_MESSAGES))
    with endpoint_qos(library, asked, _USER_DATA) as qos:
        if read_user_data(library, qos) != _USER_DATA or read_qos(library, qos) != asked.stated():
            return 'its QoS is laid out differently'
        reader = Reader(participant, 'rt/selftest', 'goalwire::msg::dds_::SelfTest_', qos)
        writer = Writer(participant, 'rt/selftest', 'goalwire::msg::dds_::SelfTest_', qos)
    if any(writer.write(message) for message in _MESSAGES):
        return 'it does not write serialized messages'
    _, taken = reader.take()
    if [each.payload[: len(sent)] for each, sent in zip(taken, _MESSAGES, strict=False)] != list(_MESSAGES):
        return 'messages do not come back as they were sent'
    if any(each.publication != writer.instance for each in taken):
        return 'messages do not tell their publisher'
    if any(abs(each.source_timestamp - time.time_ns()) > _CLOCK_NS for each in taken):
        return 'messages do not tell their time'
    return ''
