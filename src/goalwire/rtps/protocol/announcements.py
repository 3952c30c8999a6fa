"""The discovery data of participants and endpoints: the payloads of SPDP and SEDP."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from goalwire.records import record
from goalwire.rtps.protocol import bounds
from goalwire.rtps.protocol import parameters as pids
from goalwire.rtps.protocol.messages import VENDOR, VERSION
from goalwire.rtps.protocol.parameters import (
    Parameters,
    read_address,
    read_bytes,
    read_payload,
    read_text,
    read_u32,
    write_payload,
    write_text,
)
from goalwire.rtps.protocol.primitives import (
    GUID_SIZE,
    NS,
    PARTICIPANT,
    PREFIX_SIZE,
    Address,
    RtpsError,
    decode_duration,
    encode_duration,
    encode_locator,
    is_writer,
)
from goalwire.rtps.protocol.qos import READER_DEFAULT, WRITER_DEFAULT, Qos, read_qos, write_qos

ENDPOINTS = 0x0C3F
"""The built-in endpoints of this implementation: participants, publications, subscriptions, messages."""
DEFAULT_LEASE = 100 * NS
"""The standard's lease for a participant that announces none."""


@record
class ParticipantData:
    """The data that a participant announces by SPDP."""

    prefix: bytes
    vendor: bytes = VENDOR
    metatraffic: tuple[Address, ...] = ()
    """The addresses of its discovery."""
    default: tuple[Address, ...] = ()
    """The addresses of its endpoints, unless an endpoint has its own."""
    lease: int = DEFAULT_LEASE
    """Nanoseconds of silence after which the participant counts as gone."""
    endpoints: int = ENDPOINTS
    domain: int | None = None
    tag: str = ''
    user_data: bytes = b''
    name: str = ''
    receive_buffer: int = 0
    """How many bytes of unread packets the system keeps for it; 0: unknown."""


@record
class EndpointData:
    """The data that a writer or a reader announces by SEDP."""

    guid: bytes
    topic: str
    type_name: str
    qos: Qos
    user_data: bytes = b''
    addresses: tuple[Address, ...] = ()
    """The addresses of the endpoint; empty: those of its participant."""

    @property
    def prefix(self) -> bytes:
        """The GUID prefix of the endpoint's participant."""
        return self.guid[:PREFIX_SIZE]

    @property
    def entity_id(self) -> bytes:
        """The last four bytes of the GUID, unique in the participant."""
        return self.guid[PREFIX_SIZE:]


def write_participant(data: ParticipantData) -> bytes:
    """Return the payload of SPDP that announces a participant."""
    told: Parameters = [
        (pids.PROTOCOL_VERSION, VERSION),
        (pids.VENDOR_ID, data.vendor),
        (pids.PARTICIPANT_GUID, data.prefix + PARTICIPANT),
        (pids.BUILTIN_ENDPOINTS, struct.pack('<I', data.endpoints)),
        (pids.PARTICIPANT_LEASE, encode_duration(data.lease)),
    ]
    if data.domain is not None:
        told.append((pids.DOMAIN_ID, struct.pack('<I', data.domain)))
    if data.tag:
        told.append((pids.DOMAIN_TAG, write_text(data.tag)))
    told += _write_addresses(pids.METATRAFFIC_UNICAST, data.metatraffic)
    told += _write_addresses(pids.DEFAULT_UNICAST, data.default)
    if data.user_data:
        told.append((pids.USER_DATA, struct.pack('<I', len(data.user_data)) + data.user_data))
    if data.name:
        told.append((pids.ENTITY_NAME, write_text(data.name)))
    if data.receive_buffer:
        told.append((pids.RECEIVE_BUFFER, struct.pack('<I', data.receive_buffer)))
    return write_payload(told)


def read_participant(payload: bytes) -> ParticipantData:
    """Read a payload of SPDP; raises RtpsError if the payload has no GUID, or must be ignored."""
    told, order = read_payload(payload)
    values: dict[str, object] = {}
    metatraffic: list[Address] = []
    default: list[Address] = []
    for pid, value in told:
        match pid:
            case pids.PARTICIPANT_GUID:
                values['prefix'] = _guid(value)[:PREFIX_SIZE]
            case pids.VENDOR_ID:
                values['vendor'] = value[:2]
            case pids.METATRAFFIC_UNICAST:
                _add_address(metatraffic, value, order)
            case pids.DEFAULT_UNICAST:
                _add_address(default, value, order)
            case pids.PARTICIPANT_LEASE:
                if len(value) < 8:
                    raise RtpsError(f'a lease has {len(value)} bytes')
                values['lease'] = decode_duration(*struct.unpack_from('<iI' if order else '>iI', value))
            case pids.BUILTIN_ENDPOINTS:
                values['endpoints'] = read_u32(value, order)
            case pids.DOMAIN_ID:
                values['domain'] = read_u32(value, order)
            case pids.DOMAIN_TAG:
                values['tag'] = read_text(value, order)
            case pids.USER_DATA:
                values['user_data'] = _user_data(value, order)
            case pids.ENTITY_NAME:
                values['name'] = read_text(value, order)
            case pids.RECEIVE_BUFFER:
                values['receive_buffer'] = read_u32(value, order) if len(value) == 4 else 0
            case _:
                _check_unknown(pid)
    if 'prefix' not in values:
        raise RtpsError('a participant tells no GUID')
    if values.get('vendor') != VENDOR:  # to other vendors the parameter's id may mean something else
        values.pop('receive_buffer', None)
    return ParticipantData(**values, metatraffic=tuple(metatraffic), default=tuple(default))  # type: ignore[arg-type]


def write_endpoint(data: EndpointData) -> bytes:
    """Return the payload of SEDP that announces an endpoint."""
    told: Parameters = [
        (pids.ENDPOINT_GUID, data.guid),
        (pids.KEY_HASH, data.guid),
        (pids.PARTICIPANT_GUID, data.prefix + PARTICIPANT),
        (pids.TOPIC_NAME, write_text(data.topic)),
        (pids.TYPE_NAME, write_text(data.type_name)),
        *write_qos(data.qos),
        *_write_addresses(pids.UNICAST_LOCATOR, data.addresses),
    ]
    if data.user_data:
        told.append((pids.USER_DATA, struct.pack('<I', len(data.user_data)) + data.user_data))
    return write_payload(told)


def read_endpoint(payload: bytes) -> EndpointData:
    """Read a payload of SEDP; raises RtpsError if a name or the GUID is missing."""
    told, order = read_payload(payload)
    guid = topic = type_name = None
    user_data = b''
    addresses: list[Address] = []
    for pid, value in told:
        match pid:
            case pids.ENDPOINT_GUID:
                guid = _guid(value)
            case pids.TOPIC_NAME:
                topic = read_text(value, order)
            case pids.TYPE_NAME:
                type_name = read_text(value, order)
            case pids.USER_DATA:
                user_data = _user_data(value, order)
            case pids.UNICAST_LOCATOR:
                _add_address(addresses, value, order)
            case _:
                _check_unknown(pid)
    if guid is None or topic is None or type_name is None:
        raise RtpsError('an endpoint does not tell its GUID, topic and type')
    qos = read_qos(told, order, WRITER_DEFAULT if is_writer(guid[PREFIX_SIZE:]) else READER_DEFAULT)
    return EndpointData(guid, topic, type_name, qos, user_data, tuple(addresses))


def read_key(payload: bytes, pid: int) -> bytes | None:
    """Return the GUID in the parameter `pid` of a key-only payload; None if the payload does not have it."""
    for found, value in read_payload(payload)[0]:
        if found == pid:
            return _guid(value)
    return None


def write_key(pid: int, guid: bytes) -> bytes:
    """Return a payload that has only a key: the parameter `pid` with a GUID."""
    return write_payload([(pid, guid)])


def _write_addresses(pid: int, addresses: Iterable[Address]) -> Parameters:
    return [(pid, encode_locator(address)) for address in addresses]


def _add_address(addresses: list[Address], value: bytes, order: int) -> None:
    address = read_address(value, order)
    if address is not None and address not in addresses and len(addresses) < bounds.MOST_LOCATORS:
        addresses.append(address)


def _user_data(value: bytes, order: int) -> bytes:
    return read_bytes(value, order, bounds.USER_DATA_SIZE).rstrip(b'\0')


def _guid(value: bytes) -> bytes:
    if len(value) < GUID_SIZE:
        raise RtpsError(f'a GUID has {len(value)} bytes')
    return value[:GUID_SIZE]


def _check_unknown(pid: int) -> None:
    """Raise RtpsError for an unknown parameter that the standard says must be understood."""
    if pid & pids.MUST_BE_KNOWN and not pid & pids.VENDORS:
        raise RtpsError(f'parameter 0x{pid:04x} must be known, and is not')
