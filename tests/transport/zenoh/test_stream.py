"""The order of one publisher's messages, judged without a wire."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from goalwire.transport.zenoh.stream import StreamState, is_newer

A, B = b'a' * 16, b'b' * 16


class Listener:
    """A stream of one publisher, A, and what came out of it."""

    def __init__(self, *, numbered: bool = True, recovers: bool = True) -> None:
        self.came: list[int] = []
        self.stream: StreamState[int] = StreamState(
            self.came.append, 10, numbered=numbered, recovers=recovers
        )

    def live(self, *numbers: int, gid: bytes = A) -> list[str | None]:
        """Publish; returns the questions."""
        return [self.stream.live(gid, number, number, is_first=number == 0) for number in numbers]

    def answer(self, *numbers: int, gid: bytes = A) -> None:
        """Answer and end the question."""
        for number in numbers:
            self.stream.answer(gid, number, number)
        self.stream.end()


def test_what_is_published_while_the_history_comes_waits_for_its_end() -> None:
    listener = Listener()
    assert listener.stream.ask() == '_max=10'
    assert listener.live(4, 5) == [None, None]
    assert listener.came == []
    listener.answer(1, 2, 3, 4)
    assert listener.came == [1, 2, 3, 4, 5]


@pytest.mark.parametrize('numbered', [True, False])
def test_what_came_live_is_not_lost_where_the_history_has_room_for_the_last_alone(numbered: bool) -> None:
    listener = Listener(numbered=numbered)
    listener.stream.ask()
    listener.live(4, 5, 7)
    listener.live(3, gid=B)
    listener.answer(6)
    assert listener.came in ([4, 5, 6, 3, 7], [4, 5, 6, 7, 3])


def test_a_publisher_heard_before_its_token_is_asked_for_its_history() -> None:
    listener = Listener()
    assert listener.live(7) == ['_max=10']
    assert listener.stream.ask() is None
    listener.answer(5, 6, 7)
    assert listener.came == [5, 6, 7]


def test_a_publishers_first_message_needs_no_question() -> None:
    listener = Listener()
    assert listener.live(0, 1, 2) == [None, None, None]
    assert listener.came == [0, 1, 2]


def test_a_publisher_that_has_no_history_is_heard_all_the_same() -> None:
    listener = Listener()
    listener.live(7)
    listener.answer()
    assert listener.live(8) == [None]
    assert listener.came == [7, 8]


def test_what_is_missing_is_asked_for_and_comes_in_its_place() -> None:
    listener = Listener()
    listener.live(0, 1)
    assert listener.live(4, 5) == ['_sn=2..', None]
    listener.answer(2, 3, 4)
    assert listener.came == [0, 1, 2, 3, 4, 5]


def test_what_is_missing_for_good_is_passed_over() -> None:
    listener = Listener()
    listener.live(0, 3)
    listener.answer(2)
    assert listener.live(4) == [None]
    assert listener.came == [0, 2, 3, 4]


def test_without_recovery_nothing_is_asked_again() -> None:
    listener = Listener(recovers=False)
    assert listener.live(0, 3) == [None, None]
    assert listener.came == [0, 3]


def test_messages_that_overtook_each_other_are_put_in_order() -> None:
    listener = Listener()
    listener.live(0)
    assert listener.live(2) == ['_sn=1..']
    listener.live(1)
    listener.answer()
    assert listener.came == [0, 1, 2]


def test_a_heartbeat_asks_for_the_last_messages() -> None:
    listener = Listener()
    listener.live(0)
    assert listener.stream.heartbeat(0) is None
    assert listener.stream.heartbeat(2) == '_sn=1..2'
    assert listener.stream.heartbeat(2) is None
    listener.answer(1, 2)
    assert listener.stream.heartbeat(2) is None
    assert listener.came == [0, 1, 2]


def test_a_heartbeat_of_a_publisher_never_heard_asks_for_its_history() -> None:
    assert Listener().stream.heartbeat(3) == '_max=10'


def test_a_second_look_at_the_history_brings_nothing_twice() -> None:
    for numbered in (True, False):
        listener = Listener(numbered=numbered)
        listener.stream.ask()
        listener.live(3)
        listener.answer(1, 2)
        listener.stream.ask()
        listener.answer(1, 2, 3, 4)
        assert listener.came == [1, 2, 3, 4]


def test_publishers_without_numbers_of_the_wire_share_an_address() -> None:
    listener = Listener(numbered=False)
    listener.live(0)
    assert listener.live(5, gid=B) == ['_max=10']
    listener.stream.answer(B, 4, 4)
    listener.answer(0)
    assert listener.came == [0, 4, 5]


def test_threads_that_overtake_each_other_lose_nothing_where_the_wire_does_not_number() -> None:
    listener = Listener(numbered=False)
    listener.live(0, 2, 1, 3)
    assert listener.came == [0, 2, 1, 3]


def test_numbers_wrap_around() -> None:
    top = 2**32 - 1
    listener = Listener()
    listener.stream.ask()
    listener.answer(top - 1)
    listener.live(top, 0, 1)
    assert listener.came == [top - 1, top, 0, 1]
    assert listener.live(3) == ['_sn=2..']


@pytest.mark.parametrize(
    ('number', 'other', 'newer'),
    [(0, None, True), (1, 1, False), (1, 0, True), (0, 1, False), (0, 2**32 - 1, True)],
)
def test_newer_numbers(number: int, other: int | None, newer: bool) -> None:
    assert is_newer(number, other) is newer


@given(data=st.data(), published=st.integers(1, 12))
def test_whenever_messages_and_answers_meet_each_comes_once_in_order(
    data: st.DataObject, published: int
) -> None:
    """The publisher keeps everything; the wire is in order; the questions are answered at any time."""
    listener = Listener()
    kept: list[int] = []
    asked = listener.stream.ask() is not None
    heard_from = data.draw(st.integers(0, published), label='first message that reaches us live')
    for number in range(published):
        kept.append(number)
        if asked and data.draw(st.booleans(), label='answers'):
            listener.answer(*kept)
            asked = False
        if number >= heard_from:
            asked = listener.live(number)[0] is not None or asked
    if asked:
        listener.answer(*kept)
    assert listener.came == list(range(len(listener.came)))
    if heard_from < published:
        assert len(listener.came) == published


HUGE = 2_000_000_000


def test_a_number_that_recovery_cannot_reach_outdates_nothing() -> None:
    listener = Listener()
    listener.live(0, 1)
    assert listener.live(HUGE) == ['_sn=2..']
    listener.answer(2)
    assert listener.live(3, 4) == [None, None]
    assert listener.came == [0, 1, 2, HUGE, 3, 4]


def test_a_subscription_that_does_not_recover_is_not_silenced_either() -> None:
    listener = Listener(recovers=False)
    listener.live(0, HUGE, 1, HUGE + 7, 2)
    assert listener.came == [0, HUGE, 1, HUGE + 7, 2]


def test_a_huge_number_before_a_publishers_first_message_outdates_nothing() -> None:
    listener = Listener()
    assert listener.live(HUGE) == ['_max=10']
    listener.answer()
    listener.live(0, 1)
    assert listener.came == [HUGE, 0, 1]


def test_what_came_behind_a_gap_is_not_delivered_again_with_the_history() -> None:
    listener = Listener()
    listener.live(0)
    assert listener.live(5, 6) == ['_sn=1..', None]
    listener.stream.end()
    assert listener.live(6, 7) == [None, None]
    listener.stream.ask()
    listener.answer(4, 5, 6, 7, 8)
    assert listener.live(9) == [None]
    assert listener.came == [0, 5, 6, 7, 4, 8, 9]
