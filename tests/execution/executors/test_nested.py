"""spin inside callbacks (execution rule 3)."""

from __future__ import annotations

import asyncio
import threading
from functools import partial

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE

from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.execution.current_callback import current_executor, current_groups, why_it_cannot_answer
from goalwire.execution.event_queue import GuardCondition
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future, block_on
from goalwire.execution.time.steady_clock import STEADY


def deadline() -> int:
    return STEADY.now() + int(PATIENCE * 1e9)


@pytest.mark.parametrize('is_async', [False, True])
@pytest.mark.parametrize('same_group', [False, True])
def test_a_callback_may_spin_until_another_callback_completes_its_future(
    executor: Executor, node: SmallNode, is_async: bool, same_group: bool
) -> None:
    executor.add_node(node)
    group = MutuallyExclusiveCallbackGroup()
    other = group if same_group else MutuallyExclusiveCallbackGroup()
    answer: Future[int] = Future()
    seen: Future[list[object]] = Future()
    server = GuardCondition(lambda: answer.set_result(42), other, work_queue=node.work_queue)

    def ask() -> None:
        server.trigger()
        executor.spin_until_future_complete(answer, PATIENCE)
        seen.set_result([answer.result(), executor.get_nodes(), group.can_execute(server)])

    async def ask_async() -> None:
        ask()

    GuardCondition(ask_async if is_async else ask, group, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    assert seen.result() == [42, [node], False]


def test_a_nested_spin_runs_coroutine_callbacks(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    answer: Future[int] = Future()
    seen: Future[int | None] = Future()

    async def serve() -> None:
        await asyncio.sleep(0.005)
        answer.set_result(1)

    server = GuardCondition(serve, ReentrantCallbackGroup(), work_queue=node.work_queue)

    async def ask() -> None:
        server.trigger()
        executor.spin_until_future_complete(answer, PATIENCE)
        await asyncio.sleep(0)
        seen.set_result(answer.result())

    GuardCondition(ask, ReentrantCallbackGroup(), work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    assert seen.result() == 1


def test_a_lent_group_is_taken_back_before_the_callback_goes_on(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    group = MutuallyExclusiveCallbackGroup()
    answer: Future[int] = Future()
    order: list[str] = []
    seen: Future[None] = Future()

    async def long_callback() -> None:
        answer.set_result(1)
        await asyncio.sleep(0.02)  # the lender could go on meanwhile
        order.append('callback of the lent group ends')

    server = GuardCondition(long_callback, group, work_queue=node.work_queue)

    def ask() -> None:
        server.trigger()
        executor.spin_until_future_complete(answer, PATIENCE)
        order.append('the lender goes on')
        seen.set_result(None)

    GuardCondition(ask, group, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    assert order == ['callback of the lent group ends', 'the lender goes on']


def test_a_nested_spin_ends_at_its_timeout(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    seen: Future[bool] = Future()

    def ask() -> None:
        never: Future[int] = Future()
        executor.spin_until_future_complete(never, 0.02)
        seen.set_result(never.done())

    GuardCondition(ask, MutuallyExclusiveCallbackGroup(), work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    assert seen.result() is False


def test_nested_spin_once_runs_one_other_callback(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    order: list[str] = []
    other = GuardCondition(lambda: order.append('other'), None, work_queue=node.work_queue)

    def outer() -> None:
        other.trigger()
        single.spin_once(0)
        order.append('outer')

    GuardCondition(outer, None, work_queue=node.work_queue).trigger()
    single.spin_once(0)
    assert order == ['other', 'outer']


def test_a_callback_may_spin_another_executor(
    context: SmallContext, executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    inner_node = SmallNode()
    seen: Future[int] = Future()
    with SingleThreadedExecutor(context=context) as inner:
        inner.add_node(inner_node)
        guard = GuardCondition(lambda: seen.set_result(1), None, work_queue=inner_node.work_queue)

        def outer() -> None:
            guard.trigger()
            inner.spin_once(PATIENCE)

        GuardCondition(outer, None, work_queue=node.work_queue).trigger()
        executor.spin_until_future_complete(seen, PATIENCE)
    assert seen.result() == 1


def test_spin_on_a_thread_where_asyncio_runs(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)

    async def main() -> tuple[int | None, bool]:
        outer = asyncio.current_task()

        async def inner() -> int:
            await asyncio.sleep(0.001)
            return 5

        task = executor.create_task(inner)
        executor.spin_until_future_complete(task, PATIENCE)
        await asyncio.sleep(0)
        return task.result(), asyncio.current_task() is outer

    assert asyncio.run(main()) == (5, True)


def test_a_blocking_call_in_a_callback_needs_no_executor(executor: Executor, context: SmallContext) -> None:
    answer: Future[int] = Future()

    def call() -> int | None:
        thread = threading.Timer(0.01, answer.set_result, (3,))
        thread.start()
        assert block_on(answer, deadline(), context.shutdown_signal)
        thread.join()
        return answer.result()

    task = executor.create_task(call)
    executor.spin_until_future_complete(task, PATIENCE)
    assert task.result() == 3


def test_callbacks_that_block_in_calls_leave_threads_for_those_that_answer(
    context: SmallContext, node: SmallNode
) -> None:
    """Two threads, three callers, and the server they call: a pool of two alone would stand still."""
    group = ReentrantCallbackGroup()
    answers: list[Future[int]] = [Future() for _ in range(3)]
    done: Future[None] = Future()

    def serve() -> None:
        for answer in answers:
            answer.set_result(1)

    server = GuardCondition(serve, group, work_queue=node.work_queue)

    def ask(answer: Future[int]) -> None:
        if answer is answers[-1]:
            server.trigger()
        assert block_on(answer, deadline(), context.shutdown_signal)
        if answer is answers[-1]:
            done.set_result(None)

    with MultiThreadedExecutor(2, context=context) as multi:
        multi.add_node(node)
        clients = [
            GuardCondition(partial(ask, answer), group, work_queue=node.work_queue) for answer in answers
        ]
        for client in clients:
            client.trigger()
        multi.spin_until_future_complete(done, PATIENCE)
        assert done.done()


def test_a_call_that_its_own_thread_or_group_would_have_to_answer_is_told_apart(
    executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    held, free = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
    seen: Future[tuple[str | None, str | None]] = Future()

    async def ask() -> None:
        seen.set_result(
            (why_it_cannot_answer(node.work_queue, held), why_it_cannot_answer(node.work_queue, free))
        )

    GuardCondition(ask, held, work_queue=node.work_queue).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    in_group, in_other_group = seen.result() or (None, None)
    assert in_group is not None
    assert 'group of its own' in in_group
    if isinstance(executor, MultiThreadedExecutor):
        assert in_other_group is None
    else:
        assert in_other_group is not None
        assert 'MultiThreadedExecutor' in in_other_group


def test_a_server_that_another_thread_spins_can_answer(
    context: SmallContext, executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    with SingleThreadedExecutor(context=context) as other:
        task = other.create_task(why_it_cannot_answer, node.work_queue, MutuallyExclusiveCallbackGroup())
        with Spinning(executor):
            other.spin_until_future_complete(task, PATIENCE)
        assert task.result() is None


def test_outside_callbacks_nothing_stands_in_the_way(single: SingleThreadedExecutor, node: SmallNode) -> None:
    single.add_node(node)
    assert why_it_cannot_answer(node.work_queue, MutuallyExclusiveCallbackGroup()) is None
    assert current_executor() is None
    assert current_groups() == ()


def test_a_callback_knows_its_executor_and_group(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    group = MutuallyExclusiveCallbackGroup()
    seen: Future[tuple[object, object]] = Future()
    GuardCondition(
        lambda: seen.set_result((current_executor(), current_groups())), group, work_queue=node.work_queue
    ).trigger()
    executor.spin_until_future_complete(seen, PATIENCE)
    assert seen.result() == (executor, (group,))


def test_what_a_callback_held_is_forgotten_when_the_spin_is_over(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    single.add_node(node)
    held: list[object] = []

    def act() -> None:
        held.append(current_groups())
        if len(held) == 2:
            raise ValueError('in a callback')

    group = MutuallyExclusiveCallbackGroup()
    guard = GuardCondition(act, group, work_queue=node.work_queue)
    guard.trigger()
    single.spin_once(PATIENCE)
    assert current_groups() == ()
    guard.trigger()
    with pytest.raises(ValueError, match='in a callback'):
        single.spin_once(PATIENCE)
    assert current_groups() == ()
    guard.trigger()
    run, _, _ = single.wait_for_ready_callbacks(PATIENCE)
    run()
    assert held == [(group,)] * 3
    assert current_groups() == ()


def test_a_callback_in_no_group_does_not_hold_what_the_one_before_it_held(
    executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    held: list[object] = []
    done: Future[object] = Future()
    group = MutuallyExclusiveCallbackGroup()
    first = GuardCondition(lambda: held.append(current_groups()), group, work_queue=node.work_queue)
    last = GuardCondition(lambda: done.set_result(current_groups()), None, work_queue=node.work_queue)
    first.trigger()
    executor.spin_once(PATIENCE)
    last.trigger()
    executor.spin_until_future_complete(done, PATIENCE)
    assert [*held, done.result()] == [(group,), ()]
