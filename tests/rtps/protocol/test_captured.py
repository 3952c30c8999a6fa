"""Every packet that real implementations have sent is read, and written again byte by byte."""

from __future__ import annotations

from collections import Counter

import pytest
from helpers.rtps_captured import Packet, packets

from goalwire.rtps.protocol import messages
from goalwire.rtps.protocol.announcements import (
    EndpointData,
    ParticipantData,
    read_endpoint,
    read_key,
    read_participant,
    write_endpoint,
    write_participant,
)
from goalwire.rtps.protocol.messages import Data, check_header, read_body, split
from goalwire.rtps.protocol.parameters import (
    ENDPOINT_GUID,
    PARTICIPANT_GUID,
    read_list,
    read_payload,
    read_related_sample,
    status_of,
    write_list,
    write_payload,
    write_related_sample,
)
from goalwire.rtps.protocol.primitives import (
    PUBLICATIONS_WRITER,
    SPDP_WRITER,
    SUBSCRIPTIONS_WRITER,
    decode_time,
    encode_time,
)
from goalwire.rtps.protocol.qos import RELIABLE, TRANSIENT_LOCAL

PACKETS = list(packets())
DISCOVERY = {
    SPDP_WRITER: PARTICIPANT_GUID,
    PUBLICATIONS_WRITER: ENDPOINT_GUID,
    SUBSCRIPTIONS_WRITER: ENDPOINT_GUID,
}


def _title(packet: Packet) -> str:
    return f'{packet.scenario}: {packet.what}'


def test_every_packet_is_written_again_as_it_was() -> None:
    kinds: Counter[int] = Counter()
    for packet in PACKETS:
        data = packet.data
        check_header(data)
        for kind, flags, at, end in split(data):
            body = read_body(kind, data, at, end, flags)
            kinds[kind] += 1
            if body is not None:
                assert body.encode() == data[at - 4 : end], (_title(packet), body)
    assert set(kinds) >= {0x15, 0x16, 0x06, 0x07, 0x08, 0x09, 0x0E, 0x12, 0x13, 0x80}


def _data_of(writer: bytes) -> list[tuple[Packet, Data]]:
    found = []
    for packet in PACKETS:
        for kind, flags, at, end in split(packet.data):
            body = read_body(kind, packet.data, at, end, flags)
            if isinstance(body, Data) and body.writer == writer:
                found.append((packet, body))
    return found


@pytest.mark.parametrize('writer', DISCOVERY)
def test_parameter_lists_are_written_again_as_they_were(writer: bytes) -> None:
    for packet, data in _data_of(writer):
        if data.qos:
            assert write_list(read_list(data.qos)) == data.qos, _title(packet)
        if data.payload is not None:
            told, order = read_payload(data.payload)
            assert order == 1
            assert write_payload(told) == data.payload, _title(packet)


def test_participants_are_read_and_written() -> None:
    told = [(packet, data) for packet, data in _data_of(SPDP_WRITER) if not data.qos]
    assert len(told) > 20
    for packet, data in told:
        assert data.payload is not None
        participant = read_participant(data.payload)
        assert participant.prefix == packet.data[8:20], _title(packet)
        assert participant.vendor == packet.data[6:8]
        assert participant.metatraffic
        assert participant.default
        assert participant.user_data == b'enclave=/;'
        assert participant.endpoints & 0x0C3F == 0x0C3F
        assert read_participant(write_participant(participant)) == participant
    leases = {
        (packet.sender.split()[0], read_participant(data.payload or b'').lease) for packet, data in told
    }
    assert leases >= {('fastdds-3.2', 20 * 10**9), ('cyclonedds-11.0.1', 10 * 10**9)}


def _endpoints() -> dict[tuple[str, str, bool], EndpointData]:
    found = {}
    for writer in (PUBLICATIONS_WRITER, SUBSCRIPTIONS_WRITER):
        for packet, data in _data_of(writer):
            if data.payload is None or data.is_key:
                continue
            endpoint = read_endpoint(data.payload)
            assert endpoint.prefix == packet.data[8:20]
            assert read_endpoint(write_endpoint(endpoint)) == endpoint, _title(packet)
            found[packet.scenario, endpoint.topic, writer == PUBLICATIONS_WRITER] = endpoint
    return found


def test_endpoints_are_read_and_written() -> None:
    endpoints = _endpoints()
    discovery = endpoints['pose_cyclone', 'ros_discovery_info', True]
    assert discovery.type_name == 'rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_'
    assert (discovery.qos.reliability, discovery.qos.durability) == (RELIABLE, TRANSIENT_LOCAL)
    request = endpoints['setbool_fastdds32', 'rq/sbRequest', False]
    assert request.user_data.startswith(b'typehash=RIHS01_')
    assert request.qos.reliability == RELIABLE
    assert endpoints['setbool_cyclone', 'rq/sbRequest', True].user_data.startswith(b'clientid=')


def test_who_leaves_says_so_by_key_hash_or_by_key() -> None:
    gone: Counter[str] = Counter()
    for writer, pid in DISCOVERY.items():
        for packet, data in _data_of(writer):
            status, key = status_of(data.qos) if data.qos else (0, b'')
            if not status:
                continue
            guid = key or read_key(data.payload or b'', pid)
            assert guid is not None
            assert guid[:12] == packet.data[8:20], _title(packet)
            gone[packet.sender.split('-')[0]] += status == 3
    assert gone['fastdds'] > 10
    assert gone['cyclonedds'] > 10


def test_requests_and_replies_name_the_same_sample() -> None:
    named = {}
    for packet in PACKETS:
        if packet.scenario in ('setbool_fastdds32', 'setbool_fastdds214') and packet.what in (
            'request',
            'reply',
        ):
            for kind, flags, at, end in split(packet.data):
                body = read_body(kind, packet.data, at, end, flags)
                if isinstance(body, Data):
                    related = read_related_sample(body.qos)
                    assert related is not None
                    assert write_related_sample(related)[-28:] == body.qos[-28:]
                    named[packet.scenario, packet.what] = related
    for scenario in ('setbool_fastdds32', 'setbool_fastdds214'):
        assert named[scenario, 'request'].guid == named[scenario, 'reply'].guid
        assert named[scenario, 'request'].number == -1
        assert named[scenario, 'reply'].number == 1


def test_times_are_written_again_as_they_read() -> None:
    for packet in PACKETS:
        for kind, _, at, _ in split(packet.data):
            if kind == messages.INFO_TS:
                time = decode_time(*messages.TIME[1].unpack_from(packet.data, at))
                assert decode_time(*messages.TIME[1].unpack(encode_time(time))) == time


def test_a_participant_has_only_what_it_says() -> None:
    assert read_participant(write_participant(ParticipantData(b'p' * 12))) == ParticipantData(b'p' * 12)
