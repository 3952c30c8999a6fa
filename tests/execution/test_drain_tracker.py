"""What has come before a spin's future is settled is run before that spin ends."""

from __future__ import annotations

import threading
import time

import pytest
from helpers.execution import SmallContext, SmallNode
from helpers.patience import PATIENCE, soon

from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executor import Executor
from goalwire.execution.future import Future
from goalwire.execution.monotonic import STEADY
from goalwire.execution.multi_threaded import MultiThreadedExecutor
from goalwire.execution.single_threaded import SingleThreadedExecutor

COUNT = 20


@pytest.fixture(params=[MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup])
def group(request: pytest.FixtureRequest) -> CallbackGroup:
    """Each kind of group in turn."""
    chosen: CallbackGroup = request.param()
    return chosen


def test_all_events_that_came_before_the_future_are_handled_first(
    executor: Executor, node: SmallNode, group: CallbackGroup
) -> None:
    got: list[int] = []
    future: Future[None] = Future()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, group, got.append)
    executor.add_node(node)

    def arrive(_: None) -> None:
        for number in range(COUNT):
            event_queue.deliver(number)
        future.set_result(None)

    EventQueue(node.work_queue, None, arrive).deliver(None)
    executor.spin_until_future_complete(future, PATIENCE)
    assert sorted(got) == list(range(COUNT))


def test_they_are_handled_where_the_future_was_settled_before_the_spin(
    executor: Executor, node: SmallNode, group: CallbackGroup
) -> None:
    got: list[int] = []
    future: Future[None] = Future()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, group, got.append)
    executor.add_node(node)
    for number in range(COUNT):
        event_queue.deliver(number)
    future.set_result(None)
    executor.spin_until_future_complete(future, PATIENCE)
    assert sorted(got) == list(range(COUNT))


def test_what_comes_while_a_thread_settles_the_future_is_not_missed(
    executor: Executor, node: SmallNode, group: CallbackGroup
) -> None:
    executor.add_node(node)
    for _ in range(100):
        got: list[int] = []
        future: Future[None] = Future()
        event_queue: EventQueue[int] = EventQueue(node.work_queue, group, got.append)

        def arrive(event_queue: EventQueue[int] = event_queue, future: Future[None] = future) -> None:
            for number in range(COUNT):
                event_queue.deliver(number)
            future.set_result(None)

        thread = threading.Thread(target=arrive)
        thread.start()
        executor.spin_until_future_complete(future, PATIENCE)
        thread.join()
        assert sorted(got) == list(range(COUNT))


def test_events_that_wait_behind_another_callback_of_their_group_are_handled_first(
    executor: Executor, node: SmallNode
) -> None:
    group = MutuallyExclusiveCallbackGroup()
    got: list[int] = []
    future: Future[None] = Future()
    event_queue: EventQueue[int] = EventQueue(node.work_queue, group, got.append)
    executor.add_node(node)

    def arrive(_: None) -> None:
        for number in range(COUNT):
            event_queue.deliver(number)
        future.set_result(None)

    EventQueue(node.work_queue, group, arrive).deliver(None)
    executor.spin_until_future_complete(future, PATIENCE)
    assert got == list(range(COUNT))


def test_events_that_bring_new_events_for_ever_do_not_keep_a_spin_busy(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    got: list[int] = []
    future: Future[None] = Future()
    single.add_node(node)

    def echo(number: int) -> None:
        got.append(number)
        event_queue.deliver(number + COUNT)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, echo)
    for number in range(COUNT):
        event_queue.deliver(number)
    future.set_result(None)
    single.spin_until_future_complete(future, PATIENCE)
    assert got == list(range(COUNT))


def test_events_that_come_for_ever_do_not_keep_a_multi_threaded_spin_busy(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    future: Future[None] = Future()
    multi.add_node(node)
    event_queue: EventQueue[int] = EventQueue(
        node.work_queue, MutuallyExclusiveCallbackGroup(), lambda _: event_queue.deliver(0)
    )
    event_queue.deliver(0)
    future.set_result(None)
    start = time.monotonic()
    multi.spin_until_future_complete(future, PATIENCE)
    event_queue.close()
    assert time.monotonic() - start < PATIENCE, 'it ended by its deadline alone'


def test_one_spin_once_still_runs_one_callback_alone(single: SingleThreadedExecutor, node: SmallNode) -> None:
    got: list[int] = []
    future: Future[None] = Future()

    def take(number: int) -> None:
        got.append(number)
        future.set_result(None)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, take)
    single.add_node(node)
    for number in range(COUNT):
        event_queue.deliver(number)
    single.spin_once_until_future_complete(future, PATIENCE)
    single.spin_once_until_future_complete(future, PATIENCE)
    assert got == [0]


def test_its_deadline_ends_the_spin_whatever_waits(single: SingleThreadedExecutor, node: SmallNode) -> None:
    got: list[int] = []
    future: Future[None] = Future()

    def take(number: int) -> None:
        got.append(number)
        future.set_result(None)
        assert not threading.Event().wait(0.02)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, take)
    single.add_node(node)
    for number in range(COUNT):
        event_queue.deliver(number)
    single.spin_until_future_complete(future, 0.03)
    assert 1 <= len(got) <= 2


def test_what_a_late_callback_raises_comes_out_of_that_spin(executor: Executor, node: SmallNode) -> None:
    future: Future[None] = Future()

    def fail(_: int) -> None:
        raise ValueError('late')

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, fail)
    executor.add_node(node)
    event_queue.deliver(1)
    future.set_result(None)
    with pytest.raises(ValueError, match='late'):
        executor.spin_until_future_complete(future, PATIENCE)


def test_a_callback_that_blocks_on_another_thread_does_not_hold_up_the_spin(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    future: Future[None] = Future()
    freed, ended = threading.Event(), threading.Event()

    def block(_: int) -> None:
        future.set_result(None)
        assert soon(freed)
        ended.set()

    multi.add_node(node)
    EventQueue(node.work_queue, MutuallyExclusiveCallbackGroup(), block).deliver(1)
    begun = STEADY.now()
    multi.spin_until_future_complete(future, PATIENCE)
    assert STEADY.now() - begun < PATIENCE / 2 * 1e9
    freed.set()
    assert soon(ended)


def test_a_settled_future_ends_the_spin_quietly_after_the_contexts_end(
    executor: Executor, node: SmallNode, context: SmallContext
) -> None:
    got: list[int] = []
    future: Future[None] = Future()
    executor.add_node(node)
    EventQueue(node.work_queue, None, got.append).deliver(1)
    future.set_result(None)
    context.shutdown()
    executor.spin_until_future_complete(future, PATIENCE)
    assert got == []
