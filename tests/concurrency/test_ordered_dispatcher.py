"""The order of deliveries, and that nobody waits for anybody."""

from __future__ import annotations

import threading

import pytest
from helpers.patience import PATIENCE

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher


def test_nothing_is_delivered_before_the_drain() -> None:
    delivered: list[int] = []
    dispatcher = OrderedDispatcher(delivered.append)
    dispatcher.post(1)
    assert delivered == []
    dispatcher.drain()
    assert delivered == [1]


def test_an_item_posted_while_delivering_comes_after_not_within() -> None:
    events: list[str] = []

    def deliver(item: str) -> None:
        events.append(f'begin {item}')
        if item == 'first':
            dispatcher.post('second')
            dispatcher.drain()
        events.append(f'end {item}')

    dispatcher = OrderedDispatcher(deliver)
    dispatcher.post('first')
    dispatcher.drain()
    assert events == ['begin first', 'end first', 'begin second', 'end second']


def test_a_thread_that_finds_another_delivering_leaves_its_item_and_goes_on() -> None:
    inside, release = threading.Event(), threading.Event()
    delivered: list[tuple[str, str]] = []

    def deliver(item: str) -> None:
        delivered.append((item, threading.current_thread().name))
        inside.set()
        assert release.wait(PATIENCE)

    dispatcher = OrderedDispatcher(deliver)
    dispatcher.post('first')
    other = threading.Thread(target=dispatcher.drain, name='other')
    other.start()
    assert inside.wait(PATIENCE)
    dispatcher.post('second')
    dispatcher.drain()  # returns at once, although the first is still being delivered
    assert delivered == [('first', 'other')]
    release.set()
    other.join()
    assert delivered == [('first', 'other'), ('second', 'other')]


def test_no_item_of_many_threads_is_lost_and_the_order_of_each_is_kept() -> None:
    delivered: list[tuple[int, int]] = []
    dispatcher = OrderedDispatcher(delivered.append)

    def pour(number: int) -> None:
        for index in range(2000):
            dispatcher.post((number, index))
            dispatcher.drain()

    threads = [threading.Thread(target=pour, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(delivered) == 8 * 2000
    for number in range(8):
        assert [index for who, index in delivered if who == number] == list(range(2000))


def test_the_first_turn_delivers_before_it_ends_whoever_else_drains() -> None:
    delivered: list[int] = []
    dispatcher = OrderedDispatcher(delivered.append)
    with dispatcher.first_turn():
        dispatcher.post(1)
        dispatcher.drain()
        assert delivered == []
    assert delivered == [1]


def test_an_outbox_works_again_after_a_delivery_that_raised() -> None:
    delivered: list[int] = []

    def deliver(item: int) -> None:
        if item == 0:
            raise ZeroDivisionError
        delivered.append(item)

    dispatcher = OrderedDispatcher(deliver)
    dispatcher.post(0)
    with pytest.raises(ZeroDivisionError):
        dispatcher.drain()
    dispatcher.post(1)
    dispatcher.drain()
    assert delivered == [1]
