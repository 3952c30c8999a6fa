"""The message on /rosout is the one that the codec makes. Who publishes what: tests/overlay/rclpy."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import Log

from goalwire.cdr import codec
from goalwire.entities.rosout import encode_log
from goalwire.logging import LoggingSeverity, LogRecord

texts = st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'), max_size=20)


@given(
    stamp=st.integers(0, 2**31 * 10**9 - 1),
    severity=st.sampled_from(list(LoggingSeverity)),
    name=texts,
    message=texts,
    function=texts,
    file=texts,
    line=st.integers(0, 2**32 - 1),
)
def test_a_record_is_encoded_as_the_codec_encodes_its_message(
    stamp: int, severity: LoggingSeverity, name: str, message: str, function: str, file: str, line: int
) -> None:
    log = Log(level=severity, name=name, msg=message, file=file, function=function, line=line)
    log.stamp.sec, log.stamp.nanosec = divmod(stamp, 10**9)
    assert encode_log(LogRecord(stamp, severity, name, message, function, file, line)) == codec.encode(log)


@pytest.mark.parametrize(('message', 'sent'), [('a\0b', 'a\\x00b'), ('\udc80', '\\udc80')])
def test_what_a_ros_string_cannot_hold_is_spelt_out(message: str, sent: str) -> None:
    record = LogRecord(0, LoggingSeverity.INFO, 'a', message, 'f', '/x.py', 1)
    assert codec.decode(encode_log(record), Log).msg == sent
