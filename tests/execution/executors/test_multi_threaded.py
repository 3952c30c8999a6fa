"""Work that has come before a spin's future is settled is done before that spin ends."""

from __future__ import annotations

import threading
import time

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.event_queue import EventQueue
from goalwire.execution.executors.drain_tracker import DrainTracker
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.executors.worker_pool import WorkerPool
from goalwire.execution.future import Future
from goalwire.execution.ready_queue import CallbackSource, ReadyQueue
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.waiters import Waiter

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
    assert got == list(range(2 * COUNT))  # what waited, and what that has brought


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
        assert not threading.Event().wait(0.02)  # two of these take longer than the spin may

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


def test_a_callback_between_the_queue_and_its_worker_belongs_to_that_spin(
    node: SmallNode, context: SmallContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    future: Future[None] = Future()
    looked = threading.Event()

    class HoldsWork(MultiThreadedExecutor):
        """A worker that has taken the work keeps it until the ending spin has looked at all workers."""

        def _next(self) -> CallbackSource | None:
            source = super()._next()
            if source is event_queue:
                future.set_result(None)
                assert soon(looked)
            return source

    def gather(drain: DrainTracker, ready: ReadyQueue, pool: WorkerPool) -> None:
        original(drain, ready, pool)
        looked.set()

    def fail(_: int) -> None:
        raise ValueError('late')

    original = DrainTracker.gather
    monkeypatch.setattr(DrainTracker, 'gather', gather)
    monkeypatch.setattr('goalwire.execution.executors.multi_threaded._PATIENCE', int(PATIENCE * 1e9))
    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, fail)
    executor = HoldsWork(2, context=context)
    executor.add_node(node)
    event_queue.deliver(1)
    try:
        with pytest.raises(ValueError, match='late'):
            executor.spin_until_future_complete(future, PATIENCE)
    finally:
        looked.set()
        executor.shutdown()


def test_a_spin_waits_for_a_worker_that_comes_late(context: SmallContext, node: SmallNode) -> None:
    come = threading.Event()
    rounds, got = list[None](), list[int]()
    future: Future[None] = Future()
    future.set_result(None)

    class ComesLate(MultiThreadedExecutor):
        """Its workers come in the third round of the ending spin's wait, as on a busy machine."""

        def _wait(self, waiter: Waiter, deadline: int | None) -> bool:
            rounds.append(None)
            if len(rounds) == 3:
                come.set()
            return super()._wait(waiter, deadline)

        def _serve(self) -> None:
            assert soon(come)
            super()._serve()

    executor = ComesLate(2, context=context)
    executor.add_node(node)
    EventQueue(node.work_queue, None, got.append).deliver(1)
    try:
        executor.spin_until_future_complete(future, PATIENCE)
        assert got == [1]
    finally:
        come.set()
        executor.shutdown()


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


def test_of_workers_that_ask_at_once_no_more_are_let_go_than_there_are_too_many() -> None:
    asking = threading.Barrier(5, timeout=PATIENCE)
    answers: Collector[bool] = Collector()
    asked, over = threading.Event(), threading.Event()

    def serve() -> None:
        asking.wait(PATIENCE)
        answers(pool.retire())
        assert soon(asked)
        answers(pool.retire())
        assert soon(over)

    pool = WorkerPool(4, serve, over.set)
    for _ in range(5):
        pool.start_worker()
    pool.limit = 1
    asking.wait(PATIENCE)
    assert sorted(answers.expect(4, PATIENCE)) == [False, True, True, True]
    assert len(pool) == 1
    asked.set()
    assert sum(answers.expect(8, PATIENCE)) == 3
    pool.close()
    assert len(pool) == 0


def test_a_thread_lent_and_given_back_leaves_one_that_works_on(context: SmallContext) -> None:
    class Slow(MultiThreadedExecutor):
        """An executor whose workers leave together if they can."""

        both = threading.Barrier(2, timeout=PATIENCE)

        def _pass_on(self) -> None:
            try:
                self.both.wait(0.2)
            except threading.BrokenBarrierError:
                super()._pass_on()

    with pytest.warns(UserWarning, match='single thread'):
        executor = Slow(1, context=context)
    inside, given_back = threading.Event(), threading.Event()

    def blocks() -> None:
        executor.add_capacity(1)
        inside.set()
        assert soon(given_back)
        executor.add_capacity(-1)

    def helps() -> None:
        assert soon(inside)
        given_back.set()

    with Spinning(executor):
        first, second = executor.create_task(blocks), executor.create_task(helps)
        for task in (first, second):
            assert task.wait(STEADY.now() + int(PATIENCE * 1e9))
        for _ in range(20):
            later = executor.create_task(lambda: 'ran')
            assert later.wait(STEADY.now() + int(PATIENCE * 1e9))
            assert later.result() == 'ran'
        assert len(executor._pool) == 1


def test_a_shutdown_waits_for_the_threads_where_it_is_asked_to(context: SmallContext) -> None:
    executor = MultiThreadedExecutor(4, context=context)
    begun, hold, ended = threading.Event(), threading.Event(), threading.Event()

    def slow() -> None:
        begun.set()
        assert soon(hold)
        ended.set()

    task = executor.create_task(slow)
    with Spinning(executor):
        assert soon(begun)
        assert executor.shutdown(0, wait_for_threads=True) is False
        assert executor.shutdown(0.01, wait_for_threads=True) is False
        assert executor.shutdown() is True
        assert not ended.is_set()
        release = threading.Timer(0.01, hold.set)
        release.start()
        assert executor.shutdown(wait_for_threads=True) is True
        assert ended.is_set()
        assert task.done()
        release.join()


def test_a_callback_that_shuts_its_executor_down_does_not_wait_for_itself(context: SmallContext) -> None:
    executor = MultiThreadedExecutor(4, context=context)
    done: Collector[bool] = Collector()
    task = executor.create_task(lambda: done(executor.shutdown(wait_for_threads=True)))
    with Spinning(executor):
        assert done.expect(1, PATIENCE) == [True]
    assert task.exception() is None
