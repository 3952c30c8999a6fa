from __future__ import annotations

import asyncio
from typing import Any

import pytest
from helpers.patience import PATIENCE

from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.task import Task


async def seven() -> int:
    return 7


async def fails() -> int:
    raise ValueError('in coro')


def divide() -> float:
    return 1 / 0


def test_a_function_called_by_hand_is_done() -> None:
    task: Task[int] = Task(lambda a, b: a * b, (2,), {'b': 3})
    task()
    assert (task.done(), task.result(), task.executing()) == (True, 6, False)


def test_a_coroutine_function_called_by_hand_is_done() -> None:
    task: Task[int] = Task(seven)
    task()
    assert task.result() == 7


def test_an_exception_by_hand_is_kept() -> None:
    failing: Task[int] = Task(fails)
    failing()
    assert failing.done()
    assert repr(failing.exception()) == "ValueError('in coro')"
    with pytest.raises(ValueError, match='in coro'):
        failing.result()
    dividing: Task[float] = Task(divide)
    dividing()
    assert isinstance(dividing.exception(), ZeroDivisionError)


def test_a_cancelled_task_called_by_hand_runs_as_in_rclpy() -> None:
    task: Task[int] = Task(seven)
    task.cancel()
    task()
    assert (task.done(), task.cancelled(), task.result()) == (True, False, 7)


def test_a_task_by_hand_goes_on_with_the_next_call_when_what_it_awaits_is_done() -> None:
    future: Future[int] = Future()

    async def take() -> int:
        return (await future or 0) + 1

    task: Task[int] = Task(take)
    task()
    task()
    assert not task.done()
    future.set_result(1)
    task()
    assert task.result() == 2


def test_a_task_by_hand_with_an_executor_goes_on_by_itself(single: SingleThreadedExecutor) -> None:
    future: Future[int] = Future()

    async def take() -> int:
        return (await future or 0) + 1

    task: Task[int] = Task(take, executor=single)
    task()
    future.set_result(1)
    single.spin_until_future_complete(task, PATIENCE)
    assert task.result() == 2


def test_create_task_takes_functions_coroutine_functions_and_coroutines(executor: Executor) -> None:
    def add(a: int, *, b: int) -> int:
        return a + b

    for task, expected in (
        (executor.create_task(add, 1, b=3), 4),
        (executor.create_task(seven), 7),
        (executor.create_task(seven()), 7),
    ):
        assert isinstance(task, Task)
        executor.spin_until_future_complete(task, PATIENCE)
        assert task.result() == expected


def test_a_failing_task_raises_out_of_spin_and_keeps_its_exception(executor: Executor) -> None:
    for handler, kind in ((divide, ZeroDivisionError), (fails, ValueError)):
        task: Task[Any] = executor.create_task(handler)
        with pytest.raises(kind):
            executor.spin_until_future_complete(task, PATIENCE)
        assert task.done()
        assert isinstance(task.exception(), kind)
    assert executor.create_task(seven).done() is False


def test_what_cannot_be_called_raises_out_of_spin(single: SingleThreadedExecutor) -> None:
    task: Task[Any] = single.create_task(5)  # type: ignore[call-overload]
    assert isinstance(task, Task)
    with pytest.raises(TypeError, match="'int' object is not callable"):
        single.spin_once(0.1)


def test_tasks_run_in_the_order_they_were_made(single: SingleThreadedExecutor) -> None:
    order: list[int] = []
    for number in range(4):
        _ = single.create_task(order.append, number)
    for _ in range(5):
        single.spin_once(0)
    assert order == [0, 1, 2, 3]


def test_cancelling_a_running_task_cancels_it_where_it_awaits(executor: Executor) -> None:
    ended: Future[str] = Future()
    begun: Future[None] = Future()

    async def wait() -> None:
        begun.set_result(None)
        try:
            await asyncio.sleep(3600)
        except asyncio.CancelledError:
            ended.set_result('cancelled')
            raise

    task: Task[None] = executor.create_task(wait)
    executor.spin_until_future_complete(begun, PATIENCE)
    _ = executor.create_task(task.cancel)
    executor.spin_until_future_complete(ended, PATIENCE)
    assert ended.result() == 'cancelled'
    assert task.cancelled()


def test_a_task_cancelled_before_its_turn_does_not_run(single: SingleThreadedExecutor) -> None:
    ran: list[int] = []
    task: Task[None] = single.create_task(ran.append, 1)
    task.cancel()
    single.spin_once(0)
    assert ran == []
