"""Two sides agree on their terms, or do not, and say why."""

from __future__ import annotations

import pytest
from helpers.zenoh_protocol import random_bytes

from goalwire.zenoh.protocol.handshake import Handshake, Identity, State
from goalwire.zenoh.protocol.link_messages import Init, Open, Role
from goalwire.zenoh.protocol.primitives import (
    INVALID,
    MAX_LINKS,
    TO_SELF,
    UNSUPPORTED,
    Reader,
    ZenohProtocolError,
)

A, B = b'\xa1\xa2\xa3\xa4', b'\xb1\xb2\xb3\xb4'


def connector(**options: object) -> Handshake:
    identity = Identity(B, Role.PEER, 60_000, 65480)
    return Handshake(identity, connects=True, random=random_bytes, **options)  # type: ignore[arg-type]


def acceptor(zid: bytes = A, **options: object) -> Handshake:
    identity = Identity(zid, Role.ROUTER, 2500, 49152)
    return Handshake(identity, connects=False, random=random_bytes, **options)  # type: ignore[arg-type]


def test_init_is_what_zenoh_sends() -> None:
    assert connector().start().hex() == 'c10931b1b2b3b40ac8ff812701'
    assert acceptor().start() == b''


def test_both_go_by_the_lesser_of_what_they_can() -> None:
    one, other = connector(), acceptor()
    init = other.receive(Reader(one.start()))
    opening = one.receive(Reader(init))
    last = other.receive(Reader(opening))
    assert one.receive(Reader(last)) == b''
    assert one.state is other.state is State.UP
    assert one.terms is not None
    assert other.terms is not None
    assert (one.terms.zid, one.terms.role, one.terms.batch_size) == (A, Role.ROUTER, 49152)
    assert (other.terms.zid, other.terms.role, other.terms.batch_size) == (B, Role.PEER, 49152)
    assert (one.terms.lease_ms, other.terms.lease_ms) == (2500, 60_000)
    assert one.terms.first_sent == other.terms.first_received
    assert one.terms.first_received == other.terms.first_sent
    assert one.terms.qos
    assert one.terms.patch == 1


@pytest.mark.parametrize(('qos', 'patch'), [(False, 0), (False, 1), (True, 0)])
def test_what_one_side_does_not_offer_is_not_used(qos: bool, patch: int) -> None:
    other = acceptor()
    answer = Init.decode(Reader(other.receive(Reader(Init(B, Role.PEER, qos=qos, patch=patch).encode()))))
    assert (answer.qos, answer.patch) == (qos, patch)


def test_a_later_patch_is_answered_with_ours() -> None:
    answer = Init.decode(Reader(acceptor().receive(Reader(Init(B, Role.PEER, patch=5).encode()))))
    assert answer.patch == 1


@pytest.mark.parametrize(('size', 'agreed', 'bits'), [(0, 0, 7), (1, 1, 14), (2, 2, 28), (3, 2, 28)])
def test_sequence_numbers_are_as_small_as_the_other_side_has_them(size: int, agreed: int, bits: int) -> None:
    other = acceptor()
    answer = Init.decode(Reader(other.receive(Reader(Init(B, Role.PEER, number_size=size).encode()))))
    assert answer.number_size == agreed
    first = Open.decode(Reader(other.receive(Reader(Open(60_000, 5, answer.cookie).encode())))).first_number
    assert first < 1 << bits
    assert other.terms is not None
    assert other.terms.number_mask == (1 << bits) - 1


def test_a_first_number_beyond_what_was_agreed_is_refused() -> None:
    other = acceptor()
    answer = Init.decode(Reader(other.receive(Reader(Init(B, Role.PEER, number_size=0).encode()))))
    with pytest.raises(ZenohProtocolError, match='first sequence number 128 has more than 7 bits'):
        other.receive(Reader(Open(60_000, 128, answer.cookie).encode()))


def test_sizes_may_be_left_out() -> None:
    init = Init.decode(Reader(bytes.fromhex('010931b1b2b3b4')))
    assert (init.batch_size, init.qos, init.patch, init.role) == (65535, False, 0, Role.PEER)


@pytest.mark.parametrize(
    ('message', 'words', 'reason'),
    [
        ('c10831b1b2b3b40ac8ff812701', 'version 8', UNSUPPORTED),
        ('c10a31b1b2b3b40ac8ff812701', 'version 10', UNSUPPORTED),
        ('c10933b1b2b3b40ac8ff812701', 'role', UNSUPPORTED),
        ('c10931b1b2b3b405c8ff812701', 'another size', UNSUPPORTED),
        ('c10931b1b2b3b40a1000812701', 'too small', UNSUPPORTED),
        ('c10931b1b2b3b40ac8ff1e', 'must be known', UNSUPPORTED),
        ('c10931b1b2', 'announced', INVALID),
        ('e10931b1b2b3b40ac8ff00812701', 'while the handshake', INVALID),
        ('423c0000', 'while the handshake', INVALID),
    ],
)
def test_an_acceptor_refuses(message: str, words: str, reason: int) -> None:
    with pytest.raises(ZenohProtocolError, match=words) as caught:
        acceptor().receive(Reader(bytes.fromhex(message)))
    assert caught.value.reason == reason


def test_a_cookie_that_is_not_ours_is_refused() -> None:
    other = acceptor()
    other.receive(Reader(connector().start()))
    with pytest.raises(ZenohProtocolError, match='cookie'):
        other.receive(Reader(Open(60_000, 5, b'guessed').encode()))


@pytest.mark.parametrize(
    ('options', 'zid', 'words', 'reason'),
    [
        ({'is_linked': lambda zid: zid == B}, A, 'link to this session already', MAX_LINKS),
        ({}, B, 'to ourselves', TO_SELF),
    ],
)
def test_a_second_link_and_one_to_oneself_are_refused(
    options: dict[str, object], zid: bytes, words: str, reason: int
) -> None:
    one, other = connector(), acceptor(zid, **options)
    answer = Init.decode(Reader(other.receive(Reader(one.start()))))
    with pytest.raises(ZenohProtocolError, match=words) as caught:
        other.receive(Reader(Open(60_000, 5, answer.cookie).encode()))
    assert caught.value.reason == reason


def test_a_connector_refuses_another_than_it_looked_for() -> None:
    one = connector(expected=b'\xcc')
    with pytest.raises(ZenohProtocolError, match='another session'):
        one.receive(Reader(acceptor().receive(Reader(one.start()))))


def test_a_connector_refuses_more_than_it_offered() -> None:
    with pytest.raises(ZenohProtocolError, match='exceeds'):
        connector().receive(Reader(Init(A, Role.PEER, 65535, cookie=b'x').encode()))
    with pytest.raises(ZenohProtocolError, match='exceeds'):
        connector().receive(Reader(Init(A, Role.PEER, 49152, cookie=b'x', number_size=3).encode()))


def test_leases_are_said_in_seconds_or_milliseconds() -> None:
    assert Open(60_000, 92331340, b'x').encode().hex() == '423c' + 'ccba832c' + '0178'
    assert Open(2500, 0).encode().hex() == '22c41300'
    assert Open.decode(Reader(bytes.fromhex('22c413e7fb03'))).lease_ms == 2500
    assert Open.decode(Reader(bytes.fromhex('623c00'))).lease_ms == 60_000
    with pytest.raises(ZenohProtocolError, match='28 bits'):
        Open.decode(Reader(bytes.fromhex('623c8080808001')))
