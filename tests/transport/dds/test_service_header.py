"""The header before requests and replies, and the reply that refuses a request."""

from __future__ import annotations

import pytest
from helpers.captured import Captured

from goalwire.errors import RemoteError
from goalwire.transport.dds.service_header import Header, refusal, refusal_reason, unwrap, wrap


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


@pytest.mark.parametrize('reason', ['', 'no', 'no time', 'ärger', 'x' * 999])
def test_a_reason_arrives_whole(reason: str) -> None:
    header, message = unwrap(refusal(Header(7, 3), reason))
    assert header == Header(7, -3)
    assert header.sequence < 0
    assert refusal_reason(message) == reason


def test_a_reason_without_end_is_cut() -> None:
    _, message = unwrap(refusal(Header(7, 3), 'x' * 100_000))
    assert refusal_reason(message) == 'x' * 1000


@pytest.mark.parametrize(
    'message', [b'', b'\0\1\0\0', b'\0\1\0\0\xff\xff\xff\xff', b'\0\1\0\0abcd\x08\0\0\0']
)
def test_a_reason_that_cannot_be_read_is_none(message: bytes) -> None:
    assert refusal_reason(message) == ''


def test_ros_2_can_decode_it_before_it_drops_it_whatever_the_service() -> None:
    """rmw_cyclonedds decodes first, whatever follows, and looks at the header then."""
    from example_interfaces.srv import AddTwoInts
    from rcl_interfaces.srv import DescribeParameters, SetParameters
    from rclpy.serialization import deserialize_message
    from std_srvs.srv import SetBool

    _, message = unwrap(refusal(Header(7, 3), 'no time'))
    for service in (AddTwoInts, DescribeParameters, SetParameters, SetBool):
        assert deserialize_message(message, service.Response) == service.Response()
