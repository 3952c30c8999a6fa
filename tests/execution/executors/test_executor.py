from __future__ import annotations

import asyncio
import gc
import threading
import time
import weakref
from collections.abc import Callable
from functools import partial

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.held_up import HeldUp
from helpers.patience import PATIENCE, soon, wait_for

from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.execution.event_queue import EventQueue, GuardCondition
from goalwire.execution.executors.executor import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
    TimeoutObject,
    await_or_execute,
)
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.shutdown_signal import default_context, provide_default_context
from goalwire.execution.time.steady_clock import STEADY


def took(action: Callable[[], object]) -> float:
    """Return how long an action takes, in s. What it waits for a core beyond 0.1 s does not count."""
    held_up, begun = HeldUp(), STEADY.now()
    action()
    seconds = (STEADY.now() - begun) / 1e9
    return seconds - max(held_up.seconds - 0.1, 0.0)


# -- nodes


def test_a_node_is_added_once(executor: Executor, node: SmallNode) -> None:
    assert executor.add_node(node)
    assert not executor.add_node(node)
    assert node.executor is executor
    assert executor.get_nodes() == [node]


def test_adding_a_node_elsewhere_removes_it_here(context: SmallContext, node: SmallNode) -> None:
    with SingleThreadedExecutor(context=context) as one, SingleThreadedExecutor(context=context) as other:
        one.add_node(node)
        assert other.add_node(node)
        assert node.executor is other
        assert one.get_nodes() == []


def test_a_removed_node_keeps_its_executor_and_may_come_back(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    single.remove_node(node)
    assert node.executor is single
    assert single.add_node(node)
    single.remove_node(SmallNode())


def test_nodes_live_as_long_as_they_are_in_an_executor(single: SingleThreadedExecutor) -> None:
    node = SmallNode()
    single.add_node(node)
    seen = weakref.ref(node)
    del node
    gc.collect()
    (kept,) = single.get_nodes()
    assert id(kept) == id(seen())
    single.remove_node(kept)
    del kept
    gc.collect()
    assert seen() is None
    assert single.get_nodes() == []


def test_what_is_no_node_is_refused(single: SingleThreadedExecutor) -> None:
    with pytest.raises(AttributeError):
        single.add_node(5)  # type: ignore[arg-type]
    with pytest.raises(AttributeError):
        single.add_node(None)  # type: ignore[arg-type]


def test_nodes_come_and_go_while_it_spins(executor: Executor, node: SmallNode) -> None:
    ran = threading.Event()
    guard = GuardCondition(ran.set, None, work_queue=node.work_queue)
    with Spinning(executor):
        guard.trigger()
        executor.add_node(node)
        assert soon(ran)
        executor.remove_node(node)
        ran.clear()
        guard.trigger()
        turn = executor.create_task(lambda: None)
        assert turn.wait(STEADY.now() + 10**10)
        assert not ran.is_set()


# -- timeouts


def test_spin_once_waits_no_longer_than_its_timeout(executor: Executor) -> None:
    assert 0.05 <= took(lambda: executor.spin_once(timeout_sec=0.05)) < 1
    assert took(lambda: executor.spin_once(timeout_sec=0)) < 1
    assert 0.05 <= took(lambda: executor.spin_once(TimeoutObject(0.05))) < 1


def test_spin_until_future_complete_ends_at_its_timeout_and_keeps_the_node(
    executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    future: Future[int] = Future()
    assert 0.05 <= took(lambda: executor.spin_until_future_complete(future, timeout_sec=0.05)) < 1
    assert not future.done()
    assert took(lambda: executor.spin_until_future_complete(future, 0)) < 1
    assert executor.get_nodes() == [node]


def test_spin_until_future_complete_ends_in_time_however_much_there_is_to_do(
    executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)

    def go_on() -> None:
        time.sleep(0.001)  # a callback that takes its time
        guard.trigger()

    guard = GuardCondition(go_on, ReentrantCallbackGroup(), work_queue=node.work_queue)
    guard.trigger()
    assert took(lambda: executor.spin_until_future_complete(Future(), timeout_sec=0.05)) < PATIENCE / 2
    guard.destroy()


def test_spin_until_future_complete_returns_at_once_for_a_settled_future(executor: Executor) -> None:
    done: Future[int] = Future()
    done.set_result(1)
    executor.spin_until_future_complete(done)
    cancelled: Future[int] = Future()
    cancelled.cancel()
    executor.spin_until_future_complete(cancelled)
    assert cancelled.cancelled()


def test_a_thread_that_completes_the_future_ends_the_spin(executor: Executor) -> None:
    future: Future[int] = Future()
    timer = threading.Timer(0.02, future.set_result, (1,))
    timer.start()
    executor.spin_until_future_complete(future)
    assert future.result() == 1
    timer.join()


def test_spin_once_until_future_complete_ends_with_the_future(executor: Executor) -> None:
    future: Future[int] = Future()
    timer = threading.Timer(0.02, future.cancel)
    timer.start()
    executor.spin_once_until_future_complete(future, PATIENCE)
    assert future.cancelled()
    timer.join()


def test_what_is_no_future_is_refused(executor: Executor) -> None:
    with pytest.raises(AttributeError, match="'int' object has no attribute"):
        executor.spin_until_future_complete(5, 0.1)  # type: ignore[arg-type]


def test_spin_waits_for_futures_of_other_libraries_too(executor: Executor) -> None:
    from concurrent.futures import Future as OtherFuture

    other: OtherFuture[int] = OtherFuture()
    timer = threading.Timer(0.02, other.set_result, (1,))
    timer.start()
    executor.spin_until_future_complete(other, PATIENCE)  # type: ignore[arg-type]
    assert other.done()
    timer.join()


# -- one callback a turn


def test_one_spin_once_runs_one_callback(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    ran: list[int] = []
    for number in range(3):
        GuardCondition(lambda number=number: ran.append(number), None, work_queue=node.work_queue).trigger()  # type: ignore[misc]
    single.spin_once(timeout_sec=0)
    assert ran == [0]
    single.spin_once(timeout_sec=0)
    assert ran == [0, 1]


def test_one_spin_once_of_the_multi_threaded_executor_starts_one_callback(
    multi: MultiThreadedExecutor, node: SmallNode
) -> None:
    multi.add_node(node)
    ran: list[int] = []
    first = threading.Event()

    def take(event: int) -> None:
        ran.append(event)
        first.set()

    EventQueue(node.work_queue, None, take).deliver(1)
    second = GuardCondition(lambda: ran.append(2), None, work_queue=node.work_queue)
    second.trigger()
    multi.spin_once(timeout_sec=0)
    assert soon(first)
    assert ran == [1]


# -- exceptions


@pytest.mark.parametrize('kind', [ValueError, SystemExit, KeyboardInterrupt])
def test_what_a_callback_raises_comes_out_of_spin_and_spinning_goes_on(
    executor: Executor, node: SmallNode, kind: type[BaseException]
) -> None:
    executor.add_node(node)
    ran = threading.Event()

    def fails() -> None:
        raise kind('boom')

    for group in (None, MutuallyExclusiveCallbackGroup(), ReentrantCallbackGroup()):
        guard = GuardCondition(fails, group, work_queue=node.work_queue)
        for _ in range(2):
            guard.trigger()
            with pytest.raises(kind):
                executor.spin()
    GuardCondition(ran.set, None, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(executor.create_task(lambda: None), PATIENCE)
    assert soon(ran)


@pytest.mark.parametrize('kind', [ValueError, SystemExit, KeyboardInterrupt])
def test_what_a_coroutine_callback_raises_comes_out_of_spin(
    executor: Executor, node: SmallNode, kind: type[BaseException]
) -> None:
    executor.add_node(node)

    async def fails() -> None:
        await asyncio.sleep(0.001)
        raise kind('aboom')

    guard = GuardCondition(fails, MutuallyExclusiveCallbackGroup(), work_queue=node.work_queue)
    for _ in range(2):
        guard.trigger()
        with pytest.raises(kind):
            executor.spin()


def test_a_coroutine_that_fails_at_once_raises_out_of_that_very_spin_once(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)

    async def fails() -> None:
        raise ValueError('aboom')

    GuardCondition(fails, None, work_queue=node.work_queue).trigger()
    with pytest.raises(ValueError, match='aboom'):
        single.spin_once(0)


# -- the end


def test_shutdown_ends_spin_on_another_thread(executor: Executor) -> None:
    with Spinning(executor) as spinning:
        executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        assert executor.shutdown()
        assert soon(spinning.ended)
    assert spinning.error is None


def test_after_shutdown_it_does_nothing_and_takes_nothing(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    assert executor.shutdown()
    assert executor.shutdown()
    assert executor.get_nodes() == []
    executor.spin()
    executor.spin_once(timeout_sec=0.1)
    executor.spin_until_future_complete(Future(), 0.1)
    with pytest.raises(ShutdownException, match='shut down'):
        executor.add_node(node)
    with pytest.raises(ShutdownException, match='shut down'):
        _ = executor.create_task(lambda: None)
    executor.remove_node(node)


def test_shutdown_does_not_wait_for_a_callback_that_runs(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    begun, release = threading.Event(), threading.Event()

    def blocks() -> None:
        begun.set()
        release.wait(PATIENCE)

    GuardCondition(blocks, None, work_queue=node.work_queue).trigger()
    with Spinning(executor):
        assert soon(begun)
        assert took(lambda: executor.shutdown(timeout_sec=0.1)) < 1
        release.set()


def test_the_contexts_end_wakes_the_single_threaded_spin_with_an_exception(
    single: SingleThreadedExecutor, context: SmallContext
) -> None:
    with Spinning(single) as spinning:
        single.create_task(lambda: None).wait(STEADY.now() + 10**10)
        context.shutdown()
        assert soon(spinning.ended)
    assert isinstance(spinning.error, ExternalShutdownException)
    assert str(spinning.error) == ''


def test_the_contexts_end_just_ends_the_multi_threaded_spin(
    multi: MultiThreadedExecutor, context: SmallContext
) -> None:
    with Spinning(multi) as spinning:
        multi.create_task(lambda: None).wait(STEADY.now() + 10**10)
        context.shutdown()
        assert soon(spinning.ended)
    assert spinning.error is None


def test_a_context_that_ends_in_a_callback_ends_spin_quietly(
    executor: Executor, context: SmallContext
) -> None:
    ended = executor.create_task(context.shutdown)
    executor.spin()
    wait_for(ended.done, 'the callback')  # on another thread it may end after the spin


def test_spin_once_after_the_contexts_end_raises(
    single: SingleThreadedExecutor, context: SmallContext
) -> None:
    context.shutdown()
    with pytest.raises(ExternalShutdownException):
        single.spin_once(0.1)


def test_coroutines_are_cancelled_at_shutdown(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    begun, ended = threading.Event(), threading.Event()

    async def waits() -> None:
        begun.set()
        try:
            await asyncio.sleep(3600)
        finally:
            ended.set()

    GuardCondition(waits, None, work_queue=node.work_queue).trigger()
    with Spinning(executor):
        assert soon(begun)
    assert soon(ended)


def test_threads_are_made_on_demand_and_all_ended(context: SmallContext, node: SmallNode) -> None:
    multi = MultiThreadedExecutor(8, context=context)
    multi.add_node(node)
    assert len(multi._pool) == 0
    multi.spin_until_future_complete(multi.create_task(lambda: None), PATIENCE)
    assert 1 <= len(multi._pool) <= 3
    multi.shutdown()
    assert len(multi._pool) == 0


# -- creation


def test_the_default_context_is_asked_for() -> None:
    import goalwire.execution.shutdown_signal as module

    before = module._provider[:]
    context = SmallContext()
    try:
        module._provider.clear()
        with pytest.raises(RuntimeError, match='pass context='):
            default_context()
        provide_default_context(lambda: context)
        with SingleThreadedExecutor() as executor:
            assert executor.context is context
    finally:
        module._provider[:] = before


def test_a_number_of_threads_must_be_positive(context: SmallContext) -> None:
    with pytest.raises(ValueError, match='max_workers must be greater than 0'):
        MultiThreadedExecutor(num_threads=0, context=context)
    with pytest.raises(TypeError, match="'<=' not supported"):
        MultiThreadedExecutor(num_threads='x', context=context)  # type: ignore[arg-type]
    with pytest.warns(UserWarning, match='MultiThreadedExecutor is used with a single thread.'):
        MultiThreadedExecutor(num_threads=1, context=context)


def test_what_is_no_context_is_refused() -> None:
    with pytest.raises(AttributeError, match="'int' object has no attribute"):
        SingleThreadedExecutor(context=5)  # type: ignore[arg-type]


def test_leaving_the_block_shuts_down(context: SmallContext) -> None:
    with SingleThreadedExecutor(context=context) as executor:
        pass
    with pytest.raises(ShutdownException):
        _ = executor.create_task(lambda: None)


# -- for executors written by users


def test_wait_for_ready_callbacks_hands_out_one_piece_of_work(
    single: SingleThreadedExecutor, context: SmallContext, node: SmallNode
) -> None:
    single.add_node(node)
    ran: list[int] = []
    guard = GuardCondition(lambda: ran.append(1), None, work_queue=node.work_queue)
    guard.trigger()
    handler, entity, found = single.wait_for_ready_callbacks(timeout_sec=0)
    assert entity is guard
    assert found is node
    assert ran == []
    handler()
    assert ran == [1]
    with pytest.raises(TimeoutException):
        single.wait_for_ready_callbacks(timeout_sec=0.01)
    with pytest.raises(ConditionReachedException):
        single.wait_for_ready_callbacks(condition=lambda: True)
    context.shutdown()
    with pytest.raises(ExternalShutdownException):
        single.wait_for_ready_callbacks(timeout_sec=0.01)
    single.shutdown()
    with pytest.raises(ShutdownException):
        single.wait_for_ready_callbacks(timeout_sec=0.01)


def test_an_executor_written_by_a_user_replaces_spin_once(context: SmallContext, node: SmallNode) -> None:
    class Counting(Executor):
        turns = 0

        def spin_once(self, timeout_sec: float | TimeoutObject | None = None) -> None:
            handler, _, _ = self.wait_for_ready_callbacks(timeout_sec)
            self.turns += 1
            handler()

    with Counting(context=context) as executor:
        executor.add_node(node)
        ran: list[int] = []
        for number in range(3):
            GuardCondition(partial(ran.append, number), None, work_queue=node.work_queue).trigger()
        _ = executor.create_task(context.shutdown)
        executor.spin()
    assert ran == [0, 1, 2]
    assert executor.turns == 4


def test_the_plain_executor_runs_callbacks_too(context: SmallContext, node: SmallNode) -> None:
    with Executor(context=context) as executor:
        executor.add_node(node)
        task = executor.create_task(lambda: 1)
        executor.spin_until_future_complete(task, PATIENCE)
        assert task.result() == 1
        executor.spin_until_future_complete(Future(), 0.01)


def test_await_or_execute_takes_both_kinds_of_callbacks() -> None:
    async def double(number: int) -> int:
        return 2 * number

    async def main() -> tuple[int, int]:
        return await await_or_execute(double, 2), await await_or_execute(lambda number: number + 1, 2)

    assert asyncio.run(main()) == (4, 3)


def test_can_execute_asks_the_callback_group(single: SingleThreadedExecutor) -> None:
    group = MutuallyExclusiveCallbackGroup()
    guard = GuardCondition(None, group)
    assert single.can_execute(guard)
    group.beginning_execution(guard)
    assert not single.can_execute(guard)


# -- several threads and one single-threaded executor


def test_a_second_thread_waits_while_the_first_one_runs_the_callbacks(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    threads: set[int] = set()
    future: Future[int] = Future()

    def take(number: int) -> None:
        threads.add(threading.get_ident())
        if number == 50:
            future.set_result(number)

    event_queue: EventQueue[int] = EventQueue(node.work_queue, None, take)
    with Spinning(single):
        single.create_task(lambda: None).wait(STEADY.now() + 10**10)
        sender = threading.Timer(0.02, lambda: list(map(event_queue.deliver, range(51))))
        sender.start()
        single.spin_until_future_complete(future, PATIENCE)
        assert future.done()
        sender.join()
    assert len(threads) == 1
    assert threading.get_ident() not in threads


def test_a_second_thread_takes_over_when_the_first_one_leaves(single: SingleThreadedExecutor) -> None:
    future: Future[int] = Future()
    begun = threading.Event()

    def first() -> None:
        single.spin_until_future_complete(single.create_task(begun.wait, PATIENCE), PATIENCE)

    with Spinning(single, first) as spinning:
        waiting = threading.Timer(0.02, begun.set)
        waiting.start()
        single.spin_until_future_complete(single.create_task(lambda: None), PATIENCE)
        waiting.join()
        assert soon(spinning.ended)
        _ = single.create_task(future.set_result, 1)
        single.spin_until_future_complete(future, PATIENCE)
    assert future.done()


def test_a_second_thread_waits_no_longer_than_its_timeout(single: SingleThreadedExecutor) -> None:
    with Spinning(single):
        single.create_task(lambda: None).wait(STEADY.now() + 10**10)
        assert 0.05 <= took(lambda: single.spin_once(timeout_sec=0.05)) < 1


def test_a_second_spin_without_end_says_that_the_first_runs_everything(executor: Executor) -> None:
    with Spinning(executor):
        executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        with pytest.raises(
            RuntimeError, match=r'^Executor is already spinning: .* executor.add_node\(node\)'
        ):
            executor.spin()
        assert executor.create_task(lambda: None).wait(STEADY.now() + 10**10)


def test_a_spin_that_may_wait_takes_over_when_the_first_one_leaves(executor: Executor) -> None:
    future: Future[int] = Future()
    with Spinning(executor, lambda: executor.spin_until_future_complete(future, PATIENCE)) as first:
        executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        with Spinning(executor, executor.spin_or_wait) as second, Spinning(executor, executor.spin_or_wait):
            future.set_result(1)
            assert soon(first.ended)
            assert executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
            with pytest.raises(RuntimeError, match='already spinning'):
                executor.spin()
            assert not second.ended.is_set()


def test_a_spin_without_end_takes_over_from_one_with_an_end(executor: Executor) -> None:
    future: Future[int] = Future()
    with Spinning(executor, lambda: executor.spin_until_future_complete(future, PATIENCE)) as first:
        executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        with Spinning(executor):
            future.set_result(1)
            assert soon(first.ended)
            assert executor.create_task(lambda: None).wait(STEADY.now() + 10**10)


def test_an_executor_spins_again_after_an_error(executor: Executor) -> None:
    for _ in range(2):
        _ = executor.create_task(lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            executor.spin()


def test_an_idle_executor_uses_no_processor_time(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    with Spinning(executor) as spinning:
        executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        before = time.process_time()
        assert not spinning.ended.wait(0.3)
        assert time.process_time() - before < 0.05


def test_a_signal_that_comes_as_a_thread_sits_down_leaves_the_seat_free(
    single: SingleThreadedExecutor,
) -> None:
    class Interrupted(dict[str, int]):
        """Python runs a signal's handler after calls, and Ctrl-C's raises."""

        def setdefault(self, key: str, default: int = 0, /) -> int:
            super().setdefault(key, default)
            raise KeyboardInterrupt

    single._driver = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        single.spin_once(timeout_sec=0)
    assert not single._driver
    assert not single.thread_waits_alone()
