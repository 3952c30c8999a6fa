from __future__ import annotations

import threading
from collections.abc import Callable

from helpers.patience import PATIENCE

from goalwire.execution.monotonic import STEADY
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue, ReadyQueue
from goalwire.execution.spinning import NEVER, StopWhen
from goalwire.execution.timer_heap import TimerEntry, TimerHeap
from goalwire.execution.waiting import Waiter

HOME = NodeWorkQueue()


def test_work_comes_out_in_the_order_it_was_posted() -> None:
    queue = ReadyQueue()
    source = [CallbackSource(HOME, None) for _ in range(5)]
    for item in source:
        queue.post(item)
    assert [queue.pop() for _ in range(6)] == [*source, None]


def test_nobody_sleeps_while_there_is_work() -> None:
    queue = ReadyQueue()
    queue.post(CallbackSource(HOME, None))
    queue.park(Waiter(), STEADY, NEVER, None)
    assert queue.sleepers == 0


def test_nobody_sleeps_who_wants_to_leave() -> None:
    queue = ReadyQueue()
    queue.park(Waiter(), STEADY, StopWhen(lambda: True), None)
    assert queue.sleepers == 0


def test_a_sleeper_leaves_no_waker_behind_at_its_deadline() -> None:
    queue = ReadyQueue()
    queue.park(Waiter(), STEADY, NEVER, STEADY.now() + 1_000_000)
    assert queue.sleepers == 0


def test_the_thread_that_went_to_sleep_last_is_woken_first() -> None:
    queue = ReadyQueue()
    woken: list[str] = []
    queue.wakers += [lambda: woken.append('first'), lambda: woken.append('last')]
    queue.post(CallbackSource(HOME, None))
    queue.post(CallbackSource(HOME, None))
    assert woken == ['last', 'first']


def test_reclaiming_takes_one_homes_work_and_keeps_the_order_of_the_rest() -> None:
    queue, other = ReadyQueue(), NodeWorkQueue()
    mine = [CallbackSource(HOME, None) for _ in range(3)]
    theirs = [CallbackSource(other, None) for _ in range(3)]
    for pair in zip(mine, theirs, strict=True):
        for item in pair:
            queue.post(item)
    assert queue.reclaim(HOME) == mine
    assert [queue.pop() for _ in range(4)] == [*theirs, None]


def test_no_wake_up_is_lost_between_32_posters_and_4_sleepers() -> None:
    queue = ReadyQueue()
    per_poster, posters = 500, 32
    taken = [0] * 4
    all_posted = threading.Event()

    def take(index: int) -> None:
        waiter = Waiter()
        while True:
            if queue.pop() is not None:
                taken[index] += 1
            elif all_posted.is_set():
                return
            else:
                queue.park(waiter, STEADY, StopWhen(all_posted.is_set), None)

    def post() -> None:
        for _ in range(per_poster):
            queue.post(CallbackSource(HOME, None))

    takers = [threading.Thread(target=take, args=(index,)) for index in range(4)]
    senders = [threading.Thread(target=post) for _ in range(posters)]
    for thread in (*takers, *senders):
        thread.start()
    for thread in senders:
        thread.join(PATIENCE)
    all_posted.set()
    queue.wake_all()
    for thread in takers:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert sum(taken) == per_poster * posters


def test_ping_pong_between_two_threads_never_stalls() -> None:
    there, back = ReadyQueue(), ReadyQueue()
    rounds = 5000

    def take(queue: ReadyQueue, waiter: Waiter) -> CallbackSource:
        while True:
            source = queue.pop()
            if source is not None:
                return source
            deadline = STEADY.now() + int(PATIENCE * 1e9)
            queue.park(waiter, STEADY, NEVER, deadline)
            assert STEADY.now() < deadline, 'a wake-up was lost'

    def answer() -> None:
        waiter = Waiter()
        for _ in range(rounds):
            back.post(take(there, waiter))

    thread = threading.Thread(target=answer)
    thread.start()
    waiter, ball = Waiter(), CallbackSource(HOME, None)
    for _ in range(rounds):
        there.post(ball)
        assert take(back, waiter) is ball
    thread.join(PATIENCE)


def test_an_alarm_that_is_set_while_a_thread_goes_to_sleep_ends_that_sleep() -> None:
    class Wakers(list[Callable[[], None]]):
        """Has an alarm set by another thread the moment before a sleeper stands here."""

        def append(self, waker: Callable[[], None]) -> None:
            other = threading.Thread(target=timer_heap.set, args=(TimerEntry(lambda: None), STEADY.now()))
            other.start()
            other.join(PATIENCE)
            super().append(waker)

    queue = ReadyQueue()
    queue.wakers = Wakers()
    timer_heap = TimerHeap(queue.wake_one, queue.wakers)
    begun = STEADY.now()
    queue.park(Waiter(), STEADY, NEVER, begun + int(PATIENCE * 1e9), timer_heap)
    assert STEADY.now() - begun < PATIENCE * 1e9 / 2
