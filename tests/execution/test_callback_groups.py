from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.event_queue import EventQueue, GuardCondition
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor


class Overlaps:
    """Runs two callbacks that stay until both are in, or for a moment; says whether they met."""

    def __init__(self, stay: float = 0.05) -> None:
        self._stay = stay
        self._both = threading.Barrier(2, timeout=PATIENCE)
        self.met = False
        self.ran = threading.Semaphore(0)

    def callback(self) -> None:
        try:
            self._both.wait(self._stay)
            self.met = True
        except threading.BrokenBarrierError:
            self._both.reset()
        self.ran.release()

    def observe(self, executor: Executor, node: SmallNode, *groups: CallbackGroup) -> bool:
        executor.add_node(node)
        guards = [GuardCondition(self.callback, group, work_queue=node.work_queue) for group in groups]
        with Spinning(executor):
            for guard in guards:
                guard.trigger()
            for _ in guards:
                assert self.ran.acquire(timeout=PATIENCE)
        return self.met


def test_the_rclpy_methods_of_an_exclusive_group() -> None:
    group = MutuallyExclusiveCallbackGroup()
    guard = GuardCondition(None, group)
    assert not group.has_entity(guard)
    group.add_entity(guard)
    assert group.has_entity(guard)
    assert group.can_execute(guard)
    assert group.beginning_execution(guard)
    assert not group.can_execute(guard)
    assert not group.beginning_execution(guard)
    group.ending_execution(guard)
    assert group.can_execute(guard)
    with pytest.raises(TypeError, match="cannot create weak reference to 'int' object"):
        group.add_entity(5)


def test_a_reentrant_group_lets_everything_run() -> None:
    group = ReentrantCallbackGroup()
    assert group.can_execute(5)
    assert group.beginning_execution(5)
    assert group.beginning_execution(5)


def test_callbacks_of_two_exclusive_groups_overlap(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    groups = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
    assert Overlaps(PATIENCE).observe(multi, node, *groups)


def test_callbacks_of_one_exclusive_group_do_not(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    group = MutuallyExclusiveCallbackGroup()
    assert not Overlaps().observe(multi, node, group, group)


def test_callbacks_of_one_reentrant_group_overlap(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    group = ReentrantCallbackGroup()
    assert Overlaps(PATIENCE).observe(multi, node, group, group)


def test_one_thread_never_overlaps(single: SingleThreadedExecutor, node: SmallNode) -> None:
    assert not Overlaps().observe(single, node, ReentrantCallbackGroup(), ReentrantCallbackGroup())


def test_an_exclusive_group_is_held_across_await(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    order: list[str] = []
    done = threading.Event()
    group = MutuallyExclusiveCallbackGroup()

    elsewhere = threading.Event()

    async def slow() -> None:
        order.append('slow begins')
        while not elsewhere.is_set():  # noqa: ASYNC110 - what was triggered after `quick` has run
            await asyncio.sleep(0)
        order.append('slow ends')

    def quick() -> None:
        order.append('quick')
        done.set()

    guards = [GuardCondition(callback, group, work_queue=node.work_queue) for callback in (slow, quick)]
    guards.append(GuardCondition(elsewhere.set, ReentrantCallbackGroup(), work_queue=node.work_queue))
    with Spinning(executor):
        for guard in guards:
            guard.trigger()
        assert soon(done)
    assert order == ['slow begins', 'slow ends', 'quick']


def test_a_callback_that_blocks_holds_up_nobody_but_its_group(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    multi.add_node(node)
    release = threading.Event()

    async def blocks_in_a_coroutine() -> None:
        release.wait(PATIENCE)

    def blocks() -> None:
        release.wait(PATIENCE)

    slept = threading.Event()

    async def sleeps() -> None:
        await asyncio.sleep(0.01)  # somebody has to wake it, while all threads are blocked
        slept.set()

    shared = ReentrantCallbackGroup()
    source: list[tuple[Callable[[], object], CallbackGroup]] = [
        (blocks, MutuallyExclusiveCallbackGroup()),
        (blocks_in_a_coroutine, MutuallyExclusiveCallbackGroup()),
        (blocks_in_a_coroutine, shared),
        (sleeps, shared),
    ]
    guards = [GuardCondition(callback, group, work_queue=node.work_queue) for callback, group in source]
    with Spinning(multi):
        for guard in guards:
            guard.trigger()
        assert soon(slept)
        release.set()


def test_a_group_is_free_again_after_an_exception(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    group = MutuallyExclusiveCallbackGroup()

    def fails() -> None:
        raise ValueError('boom')

    async def fails_later() -> None:
        await asyncio.sleep(0)
        raise ValueError('aboom')

    for callback, text in ((fails, 'boom'), (fails_later, 'aboom')):
        guard = GuardCondition(callback, group, work_queue=node.work_queue)
        guard.trigger()
        with pytest.raises(ValueError, match=text):
            executor.spin_until_future_complete(executor.create_task(asyncio.sleep(PATIENCE)), PATIENCE)
        assert group.can_execute(guard)


def test_work_waiting_for_a_group_does_not_hold_up_other_nodes(context: SmallContext) -> None:
    """The group's next work belongs to a node that no executor runs: it must not wait in front of others."""
    group = MutuallyExclusiveCallbackGroup()
    away, here = SmallNode(), SmallNode()
    got: list[str] = []
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(here)
        held = GuardCondition(None, group)
        assert group.beginning_execution(held)
        for node, name in ((away, 'away'), (here, 'here')):
            executor.add_node(node)
            EventQueue(node.work_queue, group, got.append).deliver(name)
        executor.spin_once(0)
        executor.remove_node(away)
        group.ending_execution(held)
        executor.spin_once(0)
        assert got == ['here']


def test_parked_work_costs_no_turns(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    group = MutuallyExclusiveCallbackGroup()
    holder = GuardCondition(None, group)
    group.beginning_execution(holder)
    event_queue: EventQueue[int] = EventQueue(node.work_queue, group, lambda _: None)
    event_queue.deliver(1)
    single.spin_once(0)
    assert not single._ready.items
    group.ending_execution(holder)
    assert list(single._ready.items) == [event_queue]


# -- groups written by programs ------------------------------------------------------------------------------


class Few(CallbackGroup):
    """Lets two callbacks run beside each other."""

    def __init__(self) -> None:
        super().__init__()
        self.running: list[object] = []
        self.most = 0
        self._lock = threading.Lock()

    def can_execute(self, entity: object) -> bool:
        return len(self.running) < 2

    def beginning_execution(self, entity: object) -> bool:
        with self._lock:
            if not self.can_execute(entity):
                return False
            self.running.append(entity)
            self.most = max(self.most, len(self.running))
            return True

    def ending_execution(self, entity: object) -> None:
        with self._lock:
            self.running.remove(entity)


class Gate(MutuallyExclusiveCallbackGroup):
    """Lets nothing run while it is shut."""

    shut = True

    def can_execute(self, entity: object) -> bool:
        return not self.shut and super().can_execute(entity)


def test_a_group_of_the_programs_own_makes_the_rule(executor: Executor, node: SmallNode) -> None:
    group, ran = Few(), Collector[int]()
    guards = []
    for number in range(6):

        async def callback(number: int = number) -> None:
            while group.most < 2:  # noqa: ASYNC110 - two run beside each other
                await asyncio.sleep(0)
            ran(number)

        guards.append(GuardCondition(callback, group, work_queue=node.work_queue))
    executor.add_node(node)
    with Spinning(executor):
        for guard in guards:
            guard.trigger()
        assert sorted(ran.expect(6)) == [0, 1, 2, 3, 4, 5]
    assert group.most == 2
    assert all(entity in guards for entity in group.running)


def test_a_group_of_the_programs_own_is_asked_again_after_each_callback_and_when_woken(
    executor: Executor, node: SmallNode
) -> None:
    group, ran, other = Gate(), Collector[str](), Collector[str]()
    gated = GuardCondition(lambda: ran('gated'), group, work_queue=node.work_queue)
    free = GuardCondition(lambda: other('free'), None, work_queue=node.work_queue)
    executor.add_node(node)
    with Spinning(executor):
        gated.trigger()
        free.trigger()
        other.expect(1)
        assert ran.items == []
        group.shut = False
        executor.wake()
        ran.expect(1)
        group.shut = True
        gated.trigger()
        group.shut = False
        free.trigger()
        ran.expect(2)


def test_what_a_group_has_refused_goes_with_its_node(context: SmallContext, node: SmallNode) -> None:
    group, ran = Gate(), Collector[str]()
    with SingleThreadedExecutor(context=context) as first, SingleThreadedExecutor(context=context) as second:
        first.add_node(node)
        GuardCondition(lambda: ran('gated'), group, work_queue=node.work_queue).trigger()
        first.spin_once(timeout_sec=0)
        group.shut = False
        second.add_node(node)
        second.spin_once(timeout_sec=0)
    assert ran.items == ['gated']
