"""The reply that refuses a request."""

from __future__ import annotations

import pytest

from goalwire.transport.dds.refusal import refusal, refusal_reason
from goalwire.transport.dds.service_header import Header, unwrap


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
