"""A peer's text becomes one bounded line in errors and logs."""

from __future__ import annotations

import pytest

from goalwire.errors import PEER_TEXT_LIMIT, DecodeError, RemoteError, peer_text

HOSTILE = {
    'x\n[FATAL] [1.0] [robot]: forged': r'x\n[FATAL] [1.0] [robot]: forged',
    '\x1b[2J\x07\0\r\t\x7f': r'\x1b[2J\x07\x00\r\t\x7f',
    '\x9b31m\x85': r'\x9b31m\x85',
    'a\u2028b\u2029c': r'a\u2028b\u2029c',
    '\u202eelif\u2066\u200f\u061c': r'\u202eelif\u2066\u200f\u061c',
    'Grüße, 日本語 😀 \\n': 'Grüße, 日本語 😀 \\n',
}


@pytest.mark.parametrize(('text', 'told'), HOSTILE.items(), ids=repr)
def test_control_characters_are_spelt_out_and_all_else_stays(text: str, told: str) -> None:
    assert peer_text(text) == told
    assert peer_text(told) == told
    assert str(RemoteError(text)) == told
    assert told in str(DecodeError('pkg/msg/Type', 'field', 4, text))


@pytest.mark.parametrize('text', ['x' * 10**6, '\n' * 10**6, 'x' * (PEER_TEXT_LIMIT + 1)])
def test_a_text_without_end_is_cut(text: str) -> None:
    assert len(peer_text(text)) == PEER_TEXT_LIMIT
    assert peer_text(text).endswith('…')
    assert len(peer_text(text, 7)) == 7


def test_a_text_of_just_that_length_is_whole() -> None:
    assert peer_text('x' * PEER_TEXT_LIMIT) == 'x' * PEER_TEXT_LIMIT
