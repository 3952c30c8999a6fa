from __future__ import annotations

import threading
from typing import Any

from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.event_queue import EventQueue
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue, ReadyQueue
from goalwire.execution.single_threaded import SingleThreadedExecutor
from goalwire.execution.timer_heap import TimerEntry


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


def test_an_alarm_follows_the_node_to_another_executor(context: SmallContext, node: SmallNode) -> None:
    rung = threading.Event()
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as other:
        one.add_node(node)
        node.work_queue.set_alarm(TimerEntry(rung.set), 1)
        other.add_node(node)
        one.spin_once(0)
        assert not rung.is_set()
        other.spin_once(0)
        assert rung.is_set()


def test_changing_executors_for_ever_leaves_no_alarms_behind(context: SmallContext, node: SmallNode) -> None:
    with SingleThreadedExecutor(context=context) as executor:
        node.work_queue.set_alarm(TimerEntry(lambda: None), 2**61)
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
        node.work_queue.set_alarm(TimerEntry(lambda: None), 2**61)
        for _ in range(1000):
            one.add_node(node)
            other.add_node(node)
        assert len(one._timer_heap.heap) + len(other._timer_heap.heap) < 200


def test_an_alarm_is_dropped_while_another_thread_rings_it() -> None:
    class Rung(TimerEntry):
        """Rings on another thread as soon as somebody has looked where it is."""

        looks = 0

        def __getattribute__(self, name: str) -> Any:
            value = super().__getattribute__(name)
            if name == 'timer_heap' and value is not None and self.looks:
                self.looks -= 1
                ringing = threading.Thread(target=value.ring_due, args=(10,))
                ringing.start()
                ringing.join(PATIENCE)
            return value

    work_queue = NodeWorkQueue()
    single = SingleThreadedExecutor(context=SmallContext())
    work_queue.attach(single._ready, single._timer_heap)
    rung: list[str] = []
    alarm = Rung(lambda: rung.append('rung'))
    work_queue.set_alarm(alarm, 1)
    alarm.looks = 1
    work_queue.drop_alarm(alarm)
    assert rung == ['rung']
    assert alarm.due is None
    assert not work_queue._alarms
    single.shutdown()
