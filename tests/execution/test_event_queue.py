from __future__ import annotations

import threading

import pytest
from helpers.execution import SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.errors import InvalidHandle
from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.event_queue import EventQueue, GuardCondition
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue


def test_each_turn_handles_one_event_and_sources_take_turns(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    got: list[str] = []
    one, other = EventQueue(node.work_queue, None, got.append), EventQueue(node.work_queue, None, got.append)
    for number in range(3):
        one.deliver(f'a{number}')
        other.deliver(f'b{number}')
    single.spin_once(0)
    assert got == ['a0']
    for _ in range(5):
        single.spin_once(0)
    assert got == ['a0', 'b0', 'a1', 'b1', 'a2', 'b2']


def test_a_full_topic_drops_the_oldest_and_counts_it(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    got: list[int] = []
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got.append, depth=2)
    for number in range(5):
        event_queue.deliver(number)
    for _ in range(5):
        single.spin_once(0)
    assert got == [3, 4]
    assert event_queue.dropped == 3


def test_a_full_service_refuses_the_newest_and_counts_it(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    got: list[int] = []
    refused: list[int] = []
    event_queue: EventQueue[int] = EventQueue(
        node.work_queue, None, got.append, depth=2, refuse=refused.append
    )
    for number in range(3):
        event_queue.deliver(number)
    assert refused == [2]
    for _ in range(3):
        single.spin_once(0)
    assert got == [0, 1]
    assert event_queue.dropped == 1


def test_a_closed_inbox_runs_nothing_and_takes_nothing(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    got: list[int] = []
    refused: list[int] = []
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got.append, refuse=refused.append)
    event_queue.deliver(1)
    event_queue.close()
    event_queue.deliver(2)
    assert refused == [2]
    single.spin_once(0)
    single.spin_once(0)
    assert got == []


def test_take_goes_past_the_callback(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    got: list[int] = []
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, got.append)
    event_queue.deliver(1)
    assert event_queue.take() == 1
    assert event_queue.take() is None
    event_queue.deliver(2)
    for _ in range(3):
        single.spin_once(0)
    assert got == [2]


def test_many_events_are_one_entry_in_the_queue(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, lambda _: None)
    for number in range(1000):
        event_queue.deliver(number)
    assert len(single._ready.items) == 1


def _flood(executor: Executor, node: SmallNode, group: CallbackGroup | None) -> None:
    threads, each = 32, 200
    counts = [0] * threads
    lock = threading.Lock()
    everything = threading.Event()

    def take(sender: int) -> None:
        with lock:
            counts[sender] += 1
            if sum(counts) == threads * each:
                everything.set()

    def send(sender: int) -> None:
        for _ in range(each):
            event_queue.deliver(sender)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, group, take)
    executor.add_node(node)
    with Spinning(executor):
        senders = [threading.Thread(target=send, args=(sender,)) for sender in range(threads)]
        for thread in senders:
            thread.start()
        for thread in senders:
            thread.join(PATIENCE)
        assert soon(everything), f'{threads * each - sum(counts)} lost'
    assert counts == [each] * threads


def test_32_threads_lose_nothing_in_an_exclusive_group(executor: Executor, node: SmallNode) -> None:
    _flood(executor, node, MutuallyExclusiveCallbackGroup())


def test_32_threads_lose_nothing_in_a_reentrant_group(executor: Executor, node: SmallNode) -> None:
    _flood(executor, node, ReentrantCallbackGroup())


def test_32_threads_lose_nothing_in_no_group(executor: Executor, node: SmallNode) -> None:
    _flood(executor, node, None)


def test_events_of_one_reentrant_inbox_run_beside_each_other(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    multi.add_node(node)
    together = threading.Barrier(2, timeout=PATIENCE)
    met = threading.Event()

    def take(_: int) -> None:
        together.wait(PATIENCE)
        met.set()

    event_queue: EventQueue[int] = EventQueue(node.work_queue, ReentrantCallbackGroup(), take)
    with Spinning(multi):
        event_queue.deliver(1)
        event_queue.deliver(2)
        assert soon(met)


class InterruptedHome(NodeWorkQueue):
    """A home into which a signal's handler breaks, at the first post."""

    def __init__(self) -> None:
        super().__init__()
        self.interrupts = 1

    def post(self, source: CallbackSource) -> None:
        if self.interrupts:
            self.interrupts -= 1
            raise KeyboardInterrupt
        super().post(source)


def test_an_event_that_is_interrupted_on_its_way_is_handled_all_the_same(
    single: SingleThreadedExecutor,
) -> None:
    work_queue = InterruptedHome()
    work_queue.attach(single._ready, single._timer_heap)
    got: list[str] = []
    event_queue = EventQueue(work_queue, None, got.append)
    with pytest.raises(KeyboardInterrupt):
        event_queue.deliver('one')
    event_queue.deliver('two')
    for _ in range(2):
        single.spin_once(0)
    assert got == ['one', 'two']


def test_the_next_event_after_an_interrupt_between_two_is_handled(single: SingleThreadedExecutor) -> None:
    work_queue = InterruptedHome()
    work_queue.interrupts = 0
    work_queue.attach(single._ready, single._timer_heap)
    got: list[str] = []
    event_queue = EventQueue(work_queue, None, got.append)
    event_queue.deliver('one')
    event_queue.deliver('two')
    work_queue.interrupts = 1
    with pytest.raises(KeyboardInterrupt):
        single.spin_once(0)
    single.spin_once(0)
    assert got[-1] == 'two'


def test_triggers_before_the_callback_count_as_one(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    ran: list[int] = []
    guard = GuardCondition(lambda: ran.append(1), None, work_queue=node.work_queue)
    guard.trigger()
    guard.trigger()
    single.spin_once(0)
    single.spin_once(0)
    assert ran == [1]
    guard.trigger()
    single.spin_once(0)
    assert ran == [1, 1]


def test_a_destroyed_one_raises_invalid_handle_and_runs_nothing(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    ran: list[int] = []
    guard = GuardCondition(lambda: ran.append(1), None, work_queue=node.work_queue)
    guard.trigger()
    guard.destroy()
    single.spin_once(0)
    assert ran == []
    with pytest.raises(InvalidHandle):
        guard.trigger()
    with pytest.raises(InvalidHandle):
        _ = guard.handle


def test_one_without_a_callback_is_harmless(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    GuardCondition(None, None, work_queue=node.work_queue).trigger()
    single.spin_once(0)
    assert not single._ready.items
