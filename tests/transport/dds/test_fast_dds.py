"""What a reply of Fast DDS is read from, and what becomes of a client's requests to it."""

from __future__ import annotations

import sys
from typing import Any, Literal

import pytest
from helpers.collector import Collector
from helpers.wire import Answers, Side, service_endpoint

from goalwire.errors import TransportError
from goalwire.transport.contract import EndpointKind, Sample, SessionOptions
from goalwire.transport.dds import TRANSPORT
from goalwire.transport.dds.cyclone import fast_dds
from goalwire.transport.dds.cyclone.fast_dds import NOBODY, Calls, Translation, related_request
from goalwire.transport.dds.cyclone.library import load
from goalwire.transport.dds.service_header import Header, unwrap

GUID = bytes.fromhex('0110b4e23c1696eb337eed01 00001603')
DATA = bytes.fromhex('1507640000001000 00001604 00001303 00000000 01000000')
"""A DATA submessage of Fast DDS 2.14 with inline QoS, up to that."""
FRAGMENT = bytes.fromhex('16034cff00001c00 00001604 00001303 00000000 02000000 01000000 0100 2cff 4b0d0300')
RELATED = bytes.fromhex('0f801800') + GUID + bytes.fromhex('00000000 05000000')
STANDARD = bytes.fromhex('83001800') + GUID + bytes.fromhex('01000000 05000000')
OTHER = bytes.fromhex('71000400 00000001')
END = bytes.fromhex('01000000')
MESSAGE = bytes.fromhex('00010000 01000000')


@pytest.mark.parametrize('start', [DATA, FRAGMENT], ids=['whole', 'fragment'])
def test_a_reply_tells_whose_request_it_answers(start: bytes) -> None:
    assert related_request(start + RELATED + END) == (GUID, 5)
    assert related_request(start + OTHER + STANDARD + END) == (GUID, (1 << 32) + 5)


def test_a_reply_of_a_big_endian_machine_is_read_too() -> None:
    start = bytes([0x15, 0x02, 0, 0x64, 0, 0, 0, 16]) + DATA[8:]
    related = bytes.fromhex('800f0018') + GUID + bytes.fromhex('00000000 00000007')
    assert related_request(start + related + bytes.fromhex('00010000')) == (GUID, 7)


def test_cut_anywhere_it_tells_nothing() -> None:
    whole = DATA + RELATED + END
    assert [related_request(whole[:size]) for size in range(len(whole))] == [None] * len(whole)


@pytest.mark.parametrize(
    'start',
    [
        b'\x15\x05' + DATA[2:] + RELATED + END,
        b'\x09' + DATA[1:] + RELATED + END,
        DATA + OTHER + END,
        DATA + RELATED[:2] + b'\xff\xff' + RELATED[4:] + END,
    ],
    ids=['no inline QoS', 'another submessage', 'another parameter', 'too long a parameter'],
)
def test_what_does_not_say_so_is_nobodys(start: bytes) -> None:
    assert related_request(start) is None


class FakeWriter:
    """Takes or refuses what is written."""

    guid = GUID
    instance = 77

    def __init__(self) -> None:
        self.result = 0

    def write(self, payload: bytes) -> int:
        return self.result


def test_requests_are_found_by_how_many_their_writer_has_written() -> None:
    writer = FakeWriter()
    calls = Calls(writer)  # type: ignore[arg-type]
    calls.write(b'to a server on Cyclone DDS')
    calls.write(b'', 5)
    writer.result = -10
    assert calls.write(b'', 6) == -10
    writer.result = 0
    calls.write(b'', 7)
    assert [calls.header(number) for number in (1, 2, 3, 4)] == [NOBODY, Header(77, 5), Header(77, 7), NOBODY]
    calls.end(5)
    calls.end(5)
    assert calls.header(2) == NOBODY


def test_a_library_whose_layouts_are_not_known_is_refused_with_what_to_do(
    alone: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    library = load()
    monkeypatch.setattr(library, 'path', '/opt/ros/jazzy/lib/libddsc.so.0.10.5')
    with pytest.raises(TransportError, match=r'GOALWIRE_FASTDDS_SERVICES=1 needs Cyclone DDS 11\.0,.*unset'):
        Translation(library)


def test_a_session_that_may_not_call_fast_dds_has_no_translation(
    alone: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    domain = SessionOptions(int(alone['ROS_DOMAIN_ID']))
    for switch, translates in ('0', False), ('1', True):
        monkeypatch.setenv('GOALWIRE_FASTDDS_SERVICES', switch)
        session = TRANSPORT.open(domain)
        assert (session._context.translation is not None) == translates  # type: ignore[attr-defined]
        session.close()


# -- what the replaced function leans on, in packets of the loaded library: it fails where a new one differs


@pytest.fixture
def switch() -> str:
    """What GOALWIRE_FASTDDS_SERVICES is."""
    return '1'


@pytest.fixture
def starts(alone: dict[str, str], monkeypatch: pytest.MonkeyPatch, switch: str) -> list[bytes]:
    """What the replaced function has read of each packet."""
    monkeypatch.setenv('GOALWIRE_FASTDDS_SERVICES', switch)
    seen: list[bytes] = []

    def read(start: bytes) -> tuple[bytes, int] | None:
        seen.append(start)
        return related_request(start)

    monkeypatch.setattr(fast_dds, 'related_request', read)
    return seen


def call_three_times(sides: tuple[Side, Side]) -> None:
    """Call a server across the network; its third reply does not fit into one packet."""
    alpha, beta = sides
    sizes = iter((1, 100, 200_000))
    beta.service('/add', lambda request: request.reply(bytes(next(sizes))))
    client = alpha.client('/add')
    alpha.expect_server(client, '/add')
    for _ in range(3):
        answers = Answers()
        answers.ask(client)
        answers.expect(replies=1)


def test_the_start_of_each_packet_is_found(starts: list[bytes], sides_apart: tuple[Side, Side]) -> None:
    call_three_times(sides_apart)
    session = sides_apart[0].session
    peers = session._context.peers.known.values()  # type: ignore[attr-defined]
    writers = {int.from_bytes(peer.gid[12:], 'big') for peer in peers}
    assert [start[0] for start in starts] == [0x15, 0x15, 0x16]
    order: Literal['little', 'big'] = 'little' if starts[0][1] & 1 else 'big'
    assert [int.from_bytes(start[6:8], order) for start in starts] == [16, 16, 28]  # up to the inline QoS
    assert {int.from_bytes(start[12:16], sys.byteorder) for start in starts} <= writers
    numbers = [(int.from_bytes(start[16:20], order), int.from_bytes(start[20:24], order)) for start in starts]
    assert numbers == [(0, 1), (0, 2), (0, 3)]


@pytest.mark.parametrize('switch', ['0', ''])
def test_switched_off_nothing_of_the_library_is_replaced(
    starts: list[bytes], sides_apart: tuple[Side, Side]
) -> None:
    call_three_times(sides_apart)
    assert starts == []


def test_a_reply_that_says_whose_request_it_answers_gets_the_header_of_cyclone(
    starts: list[bytes], sides_apart: tuple[Side, Side], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A server on Cyclone puts one before its replies, too: so the client finds it in the message."""
    alpha, beta = sides_apart
    beta.node.service(service_endpoint(EndpointKind.SERVICE, '/add'), lambda request: request.reply(MESSAGE))
    port: Any = alpha.node.client(service_endpoint(EndpointKind.CLIENT, '/add'))
    alpha.graph.expect(EndpointKind.SERVICE, '/add')
    alpha.graph.wait_for(port.reaches_server)
    monkeypatch.setattr(fast_dds, 'related_request', lambda start: (port.gid, 1))
    port._fast_dds._sequences[1] = 1
    replies: Collector[Sample] = Collector()
    port.request(MESSAGE, replies, lambda _: None)
    (reply,) = replies.expect(1)
    header, message = unwrap(bytes(reply.payload))
    assert (header, message) == (Header(port._writer.instance, 1), MESSAGE)


def test_a_library_that_keeps_its_operations_elsewhere_is_refused_and_left_as_it_is(
    starts: list[bytes], dds_sides: tuple[Side, Side], monkeypatch: pytest.MonkeyPatch
) -> None:
    alpha, _ = dds_sides
    tables = dict(alpha.session._context.translation._tables)  # type: ignore[attr-defined]
    monkeypatch.setattr(fast_dds, '_OPERATIONS_AT', 0)
    with pytest.raises(
        TransportError, match=r'^GOALWIRE_FASTDDS_SERVICES=1: .* is laid out differently .*, or unset'
    ):
        alpha.client('/add')
    assert alpha.session._context.translation._tables == tables  # type: ignore[attr-defined]
    alpha.graph.expect(EndpointKind.CLIENT, '/add', 0)
