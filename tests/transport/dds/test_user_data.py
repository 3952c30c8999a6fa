"""USER_DATA, as rmw_cyclonedds writes and reads it."""

from __future__ import annotations

import pytest

from goalwire.transport.dds.user_data import (
    EndpointData,
    decode_endpoint,
    enclave_of,
    encode_endpoint,
    encode_participant,
    service_id,
)

HASH = f'RIHS01_{"a1" * 32}'


def test_a_participant_names_its_enclave() -> None:
    assert encode_participant('/') == b'enclave=/;'
    assert enclave_of(b'enclave=/robot/arm;') == '/robot/arm'


def test_a_participant_without_an_enclave_has_the_empty_one() -> None:
    assert enclave_of(b'') == ''


@pytest.mark.parametrize(
    ('data', 'raw'),
    [
        (EndpointData(HASH), f'typehash={HASH};'),
        (EndpointData(HASH, service_id='1.2'), f'serviceid=1.2;typehash={HASH};'),
        (EndpointData(HASH, client_id='1.2'), f'clientid=1.2;typehash={HASH};'),
        (EndpointData(HASH, client_id='1', takes_refusals=True), f'clientid=1;typehash={HASH};goalwire=1;'),
    ],
)
def test_an_endpoint_says_what_it_is_in_ros_2s_order(data: EndpointData, raw: str) -> None:
    assert encode_endpoint(data) == raw.encode()
    assert decode_endpoint(raw.encode()) == data


@pytest.mark.parametrize('raw', [b'', b';;', b'typehash', b'\xff\xfe', b'other=thing;'])
def test_what_cannot_be_read_counts_as_not_said(raw: bytes) -> None:
    assert decode_endpoint(raw) == EndpointData()


def test_an_id_is_sixteen_bytes_in_hex_without_zeros_the_first_in_two_columns() -> None:
    guid = bytes([0x01, 0x10, 0xAB, 0, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 1, 0xC1])
    assert service_id(guid, 258) == ' 1.10.ab.0.5.6.7.8.9.a.b.c.0.0.1.2'


@pytest.mark.parametrize('hostile', ['x\n[INFO] [1] [a]: forged', '\x1b[2J', 'a\u202eb'])
def test_what_no_log_can_show_counts_as_not_said(hostile: str) -> None:
    raw = f'typehash={hostile};serviceid=1.2;enclave={hostile};'.encode()
    assert decode_endpoint(raw) == EndpointData('', service_id='1.2')
    assert enclave_of(raw) == ''
