"""Why a goal was aborted, behind the reply that ROS 2 knows."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.rules.goals import GoalStatus, wire

REPLY = bytes.fromhex('00010000 06000000 00000000')


@given(st.binary(min_size=5, max_size=64), st.text(max_size=200).filter(lambda text: '\0' not in text))
def test_a_reason_and_its_reply_come_back_whole(payload: bytes, reason: str) -> None:
    sent = wire.with_reason(payload, reason)
    assert sent.startswith(payload)
    assert len(sent) % 4 == 0
    assert wire.split_reason(sent) == (payload, reason.encode(errors='replace').decode())


@pytest.mark.parametrize('kind', [bytes, bytearray, memoryview])
def test_a_reply_without_a_reason_is_left_as_it_is(kind: type) -> None:
    assert wire.split_reason(kind(REPLY)) == (REPLY, '')
    assert wire.split_reason(kind(wire.with_reason(REPLY, 'why'))) == (REPLY, 'why')


def test_a_long_reason_is_cut_off() -> None:
    _, reason = wire.split_reason(wire.with_reason(REPLY, 'ü' * 5000))
    assert 400 < len(reason) <= wire.REASON_LIMIT


def test_the_status_of_a_reply_with_a_reason_can_still_be_set() -> None:
    sent = wire.with_status(wire.with_reason(REPLY, 'why'), GoalStatus.CANCELED)
    assert wire.status_of(sent) is GoalStatus.CANCELED
    assert wire.split_reason(sent)[1] == 'why'


@given(st.binary(max_size=40))
def test_a_mark_behind_anything_raises_nothing(junk: bytes) -> None:
    mark = wire.with_reason(REPLY, '')[-14:]
    payload, _ = wire.split_reason(junk + mark)
    assert (junk + mark).startswith(bytes(payload))
