"""The header of requests and replies, against captured ones."""

from __future__ import annotations

import pytest
from helpers.captured import Captured

from goalwire.errors import RemoteError
from goalwire.transport.dds.service_header import Header, unwrap, wrap


def test_captured_requests_and_replies_are_read_and_written_byte_for_byte(captured: list[Captured]) -> None:
    messages = [each for each in captured if each.topic.startswith(('rq/', 'rr/'))]
    assert len(messages) > 10
    for message in messages:
        header, body = unwrap(message.payload)
        assert body[:4] == b'\0\1\0\0'
        assert wrap(header, body) == message.payload


def test_a_reply_repeats_its_requests_header(captured: list[Captured]) -> None:
    request, reply = (
        next(each for each in captured if each.what == f'AddTwoInts {half}') for half in ('request', 'reply')
    )
    assert unwrap(request.payload)[0] == unwrap(reply.payload)[0] == Header(0xE8B46C8779A46B0F, 1)


def test_the_header_is_in_the_messages_byte_order() -> None:
    big = b'\0\0\0\0' + bytes([0] * 7 + [7]) + bytes([0] * 7 + [9]) + b'body'
    assert unwrap(big) == (Header(7, 9), b'\0\0\0\0body')
    assert wrap(Header(7, 9), b'\0\0\0\0body') == big


@pytest.mark.parametrize('size', range(21))
def test_what_is_too_short_for_a_header_and_a_message_is_refused(size: int) -> None:
    with pytest.raises(RemoteError, match=f'{size} bytes are too few'):
        unwrap(bytes(size))
