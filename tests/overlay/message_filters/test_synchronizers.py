"""Messages matched by their time."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from message_filters import ApproximateTimeSynchronizer, SimpleFilter, TimeSynchronizer
from std_msgs.msg import Header, String


class Stamped:
    """A message with a header, as synchronizers see it; its stamp in ms."""

    def __init__(self, name: str, milliseconds: float) -> None:
        self.name = name
        self.header = Header(stamp=Time(nanosec=round(milliseconds * 1_000_000)))


def stamped(text: str) -> Stamped:
    """Return the message 'a12': of input a, sent at 12 ms."""
    return Stamped(text, float(text[1:]))


class Bench:
    """Inputs a, b, c, … of a synchronizer, and the sets that came out."""

    def __init__(self, inputs: int, make: Any, *args: Any, **options: Any) -> None:
        self.inputs = [SimpleFilter() for _ in range(inputs)]
        self.synchronizer = make(self.inputs, *args, **options)
        self.sets: list[str] = []
        self.synchronizer.registerCallback(self._note)

    def _note(self, *messages: Stamped) -> None:
        self.sets.append(' '.join(message.name for message in messages))

    def feed(self, text: str) -> list[str]:
        """Bring the messages 'a1 b1 …' in this order; return the sets that came of them."""
        self.sets = []
        for name in text.split():
            self.inputs[ord(name[0]) - ord('a')].signalMessage(stamped(name))
        return self.sets


def test_messages_of_one_stamp_come_together() -> None:
    bench = Bench(3, TimeSynchronizer, 10)
    assert bench.feed('a1 b1') == []
    assert bench.feed('c1') == ['a1 b1 c1']


def test_each_message_is_used_once() -> None:
    bench = Bench(2, TimeSynchronizer, 10)
    assert bench.feed('a1 b1 b1 a1') == ['a1 b1', 'a1 b1']
    assert bench.feed('b1') == []


def test_exact_means_to_the_nanosecond() -> None:
    bench = Bench(2, TimeSynchronizer, 10)
    assert bench.feed('a1 b1.000001') == []
    assert bench.feed('b1') == ['a1 b1']


def test_messages_may_come_in_any_order_and_older_ones_stay() -> None:
    bench = Bench(2, TimeSynchronizer, 10)
    assert bench.feed('a1 a2 a3 b3 b1 b2') == ['a3 b3', 'a1 b1', 'a2 b2']


def test_a_full_queue_drops_the_oldest_stamp() -> None:
    bench = Bench(2, TimeSynchronizer, 2)
    assert bench.feed('a1 a2 a3 b1') == []
    assert bench.feed('b2 b3') == ['a2 b2', 'a3 b3']


def test_a_message_without_a_header_is_an_error_of_the_exact_one() -> None:
    bench = Bench(1, TimeSynchronizer, 2)
    with pytest.raises(AttributeError, match='header'):
        bench.inputs[0].signalMessage(String())


@pytest.mark.parametrize(
    ('fed', 'sets'),
    [
        ('a10 b14', ['a10 b14']),  # within the slop of 5 ms
        ('a10 b15', []),  # exactly the slop is too far
        ('a10 b16', []),
        ('b14 a10', ['a10 b14']),
        ('a10 a13 b14', ['a13 b14']),  # the nearest
        ('a10 a18 b14', ['a10 b14']),  # equally near: the one that came first
        ('a10 b14 b11', ['a10 b14']),  # used up
        ('a10 a14 b12 b13', ['a10 b12', 'a14 b13']),
    ],
)
def test_two_inputs_are_matched_within_the_slop(fed: str, sets: Sequence[str]) -> None:
    assert Bench(2, ApproximateTimeSynchronizer, 10, 0.005).feed(fed) == sets


@pytest.mark.parametrize(
    ('fed', 'sets'),
    [
        ('a10 b12 c14', ['a10 b12 c14']),
        ('a10 b17 c14', []),  # each near c, but not each other
        ('a10 b17 b11 c14', ['a10 b11 c14']),  # so the second nearest b
        ('a10 a16 b17 c14', ['a16 b17 c14']),
    ],
)
def test_all_stamps_of_a_set_lie_within_the_slop(fed: str, sets: Sequence[str]) -> None:
    assert Bench(3, ApproximateTimeSynchronizer, 10, 0.005).feed(fed) == sets


def test_of_several_complete_sets_the_nearest_stamps_are_taken_topic_by_topic() -> None:
    bench = Bench(3, ApproximateTimeSynchronizer, 10, 0.1)
    assert bench.feed('b1 b2 b9 c3 c8 a7') == ['a7 b9 c8']


def test_a_full_approximate_queue_drops_the_oldest_stamp_even_if_it_is_the_newcomer() -> None:
    bench = Bench(2, ApproximateTimeSynchronizer, 2, 0.005)
    assert bench.feed('b10 a20 a30 a10') == []
    assert bench.feed('b21') == ['a20 b21']


def test_the_approximate_one_finds_a_match_among_many_hopeless_combinations() -> None:
    bench = Bench(8, ApproximateTimeSynchronizer, 100, 0.02)
    for name in 'abcdefg':
        start = 125 if name == 'g' else 100  # each near 115, but g not near the others
        bench.feed(' '.join(f'{name}{start + number / 1000}' for number in range(40)))
    assert bench.feed('h115') == []
    assert bench.feed('g110') == ['a100.039 b100.039 c100.039 d100.039 e100.039 f100.039 g110 h115']


def test_headerless_messages_are_dropped_unless_allowed() -> None:
    bench = Bench(1, ApproximateTimeSynchronizer, 10, 0.1)
    bench.inputs[0].signalMessage(String(data='dropped'))
    assert bench.synchronizer.queues == [{}]
    came: list[tuple[String, ...]] = []
    allowed = Bench(2, ApproximateTimeSynchronizer, 10, 5.0, allow_headerless=True)
    allowed.synchronizer.callbacks.clear()
    allowed.synchronizer.registerCallback(lambda *messages: came.append(messages))
    for input_, text in zip(allowed.inputs, ('a', 'b'), strict=True):
        input_.signalMessage(String(data=text))
    assert came == [(String(data='a'), String(data='b'))]


def test_arrival_times_may_stand_in_for_the_stamps() -> None:
    bench = Bench(2, ApproximateTimeSynchronizer, 10, 5.0, sync_arrival_time=True)
    assert bench.feed('a1 b900') == ['a1 b900']


@pytest.mark.parametrize('make', [TimeSynchronizer, ApproximateTimeSynchronizer])
def test_a_callback_may_feed_the_synchronizer_again(make: Any) -> None:
    bench = Bench(2, make, 10, *([0.005] if make is ApproximateTimeSynchronizer else []))
    again = threading.Event()

    def feed_again(*_: Stamped) -> None:
        if not again.is_set():
            again.set()
            for input_, name in zip(bench.inputs, ('a20', 'b20'), strict=True):
                input_.signalMessage(stamped(name))

    bench.synchronizer.registerCallback(feed_again)
    assert bench.feed('a10 b10') == ['a10 b10', 'a20 b20']
