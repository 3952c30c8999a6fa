"""Numbers, extensions, ids and timestamps are written and read as Zenoh has them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.zenoh.protocol import primitives
from goalwire.zenoh.protocol.primitives import (
    Reader,
    SourceInfo,
    ZenohProtocolError,
    decode_source,
    decode_timestamp,
    decode_z,
    encode_padded,
    encode_source,
    encode_text,
    encode_timestamp,
    encode_z,
    ntp64,
    read_id,
    show_id,
)

U64 = st.integers(0, 2**64 - 1)


@pytest.mark.parametrize(
    ('number', 'encoded'),
    [
        (0, '00'),
        (127, '7f'),
        (128, '80 01'),
        (5000, '88 27'),
        (600000, 'c0 cf 24'),
        (264473299, 'd3 95 8e 7e'),
        (2**32 - 1, 'ff ff ff ff 0f'),
        (0x6B02B06BAB8B2F20, 'a0 de ac dc ba 8d ac 81 6b'),
        (2**64 - 1, 'ff ff ff ff ff ff ff ff ff'),
    ],
)
def test_numbers_are_written_as_captured(number: int, encoded: str) -> None:
    assert encode_z(number).hex(' ') == encoded
    assert decode_z(bytes.fromhex(encoded), 0) == (number, len(encode_z(number)))


@given(U64)
def test_every_number_is_read_as_it_was_written(number: int) -> None:
    data = encode_z(number)
    assert decode_z(b'x' + data + b'y', 1) == (number, 1 + len(data))
    assert len(data) <= 9
    assert Reader(data).z() == number


@given(st.integers(0, 2**28 - 1))
def test_padded_numbers_have_four_bytes_and_are_read_as_any(number: int) -> None:
    data = encode_padded(number)
    assert len(data) == 4
    assert decode_z(data, 0) == (number, 4)


@given(U64)
def test_a_number_that_is_cut_off_is_refused(number: int) -> None:
    data = encode_z(number)
    for size in range(len(data)):
        with pytest.raises(ZenohProtocolError, match='cut off'):
            Reader(data[:size]).z()


def test_a_number_that_its_field_does_not_hold_is_refused() -> None:
    assert Reader(encode_z(65535)).z(16) == 65535
    with pytest.raises(ZenohProtocolError, match='does not fit 16 bits'):
        Reader(encode_z(65536)).z(16)


def test_a_length_beyond_the_message_takes_no_memory() -> None:
    with pytest.raises(ZenohProtocolError, match='4294967295 bytes announced'):
        Reader(encode_z(2**32 - 1) + b'abc').take_sized()


def test_a_reader_stops_at_the_end_of_its_message() -> None:
    reader = Reader(b'\x01\x02\x03', 0, 2)
    assert (reader.u8(), reader.u8()) == (1, 2)
    with pytest.raises(ZenohProtocolError):
        reader.u8()


def test_ids_are_shown_as_numbers() -> None:
    wire = bytes.fromhex('afeedb242ecacd87e2cfd628d1cc852e')
    assert show_id(wire) == '2e85ccd128d6cfe287cdca2e24dbeeaf'
    assert show_id(b'\x01\x0a') == 'a01'


@given(st.binary(min_size=1, max_size=16).filter(lambda zid: zid[-1] != 0))
def test_ids_are_read_as_they_are_shown(zid: bytes) -> None:
    assert read_id(show_id(zid)) == zid


@given(U64, st.binary(min_size=1, max_size=16))
def test_timestamps_make_the_round_trip(time: int, zid: bytes) -> None:
    stamp = decode_timestamp(encode_timestamp(time, zid))
    assert (stamp.time, stamp.zid) == (time, zid)


@given(st.binary(min_size=1, max_size=16), st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_sources_make_the_round_trip(zid: bytes, entity: int, number: int) -> None:
    assert decode_source(encode_source(SourceInfo(zid, entity, number))) == (zid, entity, number)


def test_times_are_seconds_and_fractions() -> None:
    assert ntp64(1_500_000_000) == 1 << 32 | 1 << 31


def test_unknown_extensions_are_stepped_over_unless_they_must_be_known() -> None:
    plain = Reader(bytes((0x8E, 0xAD, 5, 0x4C, 2)) + b'ab' + b'rest')
    assert plain.extensions() == {}
    assert plain.take(4) == b'rest'
    with pytest.raises(ZenohProtocolError, match='must be known') as caught:
        Reader(b'\x1e').extensions()
    assert caught.value.reason == primitives.UNSUPPORTED


def test_an_extension_is_known_by_its_number_and_its_form() -> None:
    number, unit = b'\xa1\x07', b'\x01'
    assert Reader(number + unit).extensions({0x21}) == {0x21: 7}
    assert Reader(number + unit).extensions({0x01}) == {0x01: 0}


def test_texts_that_are_no_utf8_are_refused() -> None:
    assert Reader(encode_text('ä')).text() == 'ä'
    with pytest.raises(ZenohProtocolError, match='UTF-8'):
        Reader(b'\x01\xff').text()
