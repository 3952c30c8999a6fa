from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.executors.stop_conditions import NEVER, StopWhen
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue, ReadyQueue
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.time.timer_heap import TimerEntry, TimerHeap
from goalwire.execution.waiters import Waiter

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


def test_an_entry_that_is_set_while_a_thread_goes_to_sleep_ends_that_sleep() -> None:
    class Wakers(list[Callable[[], None]]):
        """Has an entry set by another thread the moment before a sleeper stands here."""

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


def test_work_posted_before_a_node_has_an_executor_is_run_when_it_gets_one(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    got: list[int] = []
    event_queue = EventQueue(node.work_queue, None, got.append)
    event_queue.deliver(1)
    single.spin_once(0)
    assert got == []
    single.add_node(node)
    single.spin_once(0)
    assert got == [1]


def test_pending_work_moves_to_the_executor_that_the_node_is_added_to(
    context: SmallContext, node: SmallNode
) -> None:
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as other:
        got: list[int] = []
        one.add_node(node)
        event_queues = [EventQueue(node.work_queue, None, got.append) for _ in range(3)]
        for number, event_queue in enumerate(event_queues):
            event_queue.deliver(number)
        other.add_node(node)
        for _ in range(5):
            one.spin_once(0)
        assert got == []
        for _ in range(3):
            other.spin_once(0)
        assert got == [0, 1, 2]


def test_adding_and_removing_a_node_with_each_call_keeps_pending_work_and_its_order(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    got: list[int] = []
    event_queues = [EventQueue(node.work_queue, None, got.append) for _ in range(4)]
    for number, event_queue in enumerate(event_queues):
        event_queue.deliver(number)
    for _ in range(4):
        single.add_node(node)
        single.spin_once(0)
        single.remove_node(node)
    assert got == [0, 1, 2, 3]


def test_an_entry_follows_the_node_to_another_executor(context: SmallContext, node: SmallNode) -> None:
    rung = threading.Event()
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as other:
        one.add_node(node)
        node.work_queue.set_timer_entry(TimerEntry(rung.set), 1)
        other.add_node(node)
        one.spin_once(0)
        assert not rung.is_set()
        other.spin_once(0)
        assert rung.is_set()


def test_changing_executors_for_ever_leaves_no_entries_behind(context: SmallContext, node: SmallNode) -> None:
    with SingleThreadedExecutor(context=context) as executor:
        entry = TimerEntry(lambda: None)
        node.work_queue.set_timer_entry(entry, 2**61)
        for _ in range(1000):
            executor.add_node(node)
            executor.remove_node(node)
        assert len(executor._timer_heap.heap) == 1


def test_nothing_is_lost_while_a_node_changes_executors_under_load(context: SmallContext) -> None:
    node = SmallNode()
    count = 5000
    got: list[int] = []
    everything = threading.Event()

    def take(number: int) -> None:
        got.append(number)
        if len(got) == count:
            everything.set()

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, take)
    one, other = SingleThreadedExecutor(context=context), SingleThreadedExecutor(context=context)
    with Spinning(one), Spinning(other):
        sender = threading.Thread(target=lambda: list(map(event_queue.deliver, range(count))))
        sender.start()
        for turn in range(100):
            (one, other)[turn % 2].add_node(node)
        sender.join(PATIENCE)
        assert soon(everything)
    assert sorted(got) == list(range(count))


def test_a_post_that_meets_a_detach_is_not_left_in_the_old_queue() -> None:
    work_queue = NodeWorkQueue()
    single = SingleThreadedExecutor(context=SmallContext())
    source = CallbackSource(work_queue, None)

    class Queue(ReadyQueue):
        """Has its home detached at the very moment after a post has read `home.queue`."""

        __slots__ = ()

        def __getattribute__(self, name: str) -> Any:
            if name == 'items' and work_queue.queue is self:
                work_queue.detach()
            return super().__getattribute__(name)

    queue = Queue()
    work_queue.attach(queue, single._timer_heap)
    work_queue.post(source)
    assert not queue.items
    assert list(work_queue._backlog) == [source]
    single.shutdown()


def test_a_slow_timer_of_a_node_that_moves_for_ever_leaves_little_behind(
    context: SmallContext, node: SmallNode
) -> None:
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as other:
        entry = TimerEntry(lambda: None)
        node.work_queue.set_timer_entry(entry, 2**61)
        for _ in range(1000):
            one.add_node(node)
            other.add_node(node)
        assert len(one._timer_heap.heap) + len(other._timer_heap.heap) < 200


def test_an_entry_is_discarded_while_another_thread_is_called_it() -> None:
    class Rung(TimerEntry):
        """Rings on another thread as soon as somebody has looked where it is."""

        looks = 0

        def __getattribute__(self, name: str) -> Any:
            value = super().__getattribute__(name)
            if name == 'timer_heap' and value is not None and self.looks:
                self.looks -= 1
                ringing = threading.Thread(target=value.call_due, args=(10,))
                ringing.start()
                ringing.join(PATIENCE)
            return value

    work_queue = NodeWorkQueue()
    single = SingleThreadedExecutor(context=SmallContext())
    work_queue.attach(single._ready, single._timer_heap)
    rung: list[str] = []
    entry = Rung(lambda: rung.append('rung'))
    work_queue.set_timer_entry(entry, 1)
    entry.looks = 1
    work_queue.discard_timer_entry(entry)
    assert rung == ['rung']
    assert entry.due is None
    assert not work_queue._timer_entries
    single.shutdown()
