from __future__ import annotations

import asyncio
import gc
import os
import signal
import threading
import tracemalloc
from collections.abc import Callable

import pytest
from helpers.execution import SmallContext, SmallNode
from helpers.patience import PATIENCE

from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.future import Future
from goalwire.execution.shutdown_signal import ShutdownSignal
from goalwire.execution.time.steady_clock import STEADY, Sleeper, SteadyClock


class Decoded(Future[int]):
    """Its raw form is text."""

    decoded = 0

    def decode(self, raw: object, /) -> int:
        type(self).decoded += 1
        return int(str(raw))


def in_10_s() -> int:
    return STEADY.now() + int(PATIENCE * 1e9)


def test_a_new_future_has_nothing() -> None:
    future: Future[int] = Future()
    state = future.done(), future.cancelled(), future.result(), future.exception()
    assert state == (
        False,
        False,
        None,
        None,
    )


def test_a_result_may_be_set_again() -> None:
    future: Future[int] = Future()
    future.set_result(1)
    assert (future.done(), future.result()) == (True, 1)
    future.set_result(2)
    assert future.result() == 2


def test_a_result_does_not_take_an_exception_away() -> None:
    future = Future[int]()
    future.set_exception(ArithmeticError('the first'))
    future.set_result(1)
    assert isinstance(future.exception(), ArithmeticError)
    with pytest.raises(ArithmeticError, match='the first'):
        future.result()


def test_result_raises_the_exception_and_exception_returns_it() -> None:
    future: Future[int] = Future()
    error = ValueError('v')
    future.set_exception(error)
    assert future.done()
    with pytest.raises(ValueError, match='v'):
        future.result()
    assert future.exception() is error


def test_what_is_no_exception_is_kept_and_raises_type_error() -> None:
    future: Future[int] = Future()
    future.set_exception('notexc')  # type: ignore[arg-type]
    assert future.exception() == 'notexc'  # type: ignore[comparison-overlap]
    with pytest.raises(TypeError):
        future.result()


def test_a_cancelled_future_is_not_done_and_may_still_get_a_result() -> None:
    future: Future[int] = Future()
    future.cancel()
    state = future.done(), future.cancelled(), future.result(), future.exception()
    assert state == (
        False,
        True,
        None,
        None,
    )
    future.set_result(3)
    assert (future.result(), future.done(), future.cancelled()) == (3, True, False)


def test_cancelling_a_done_future_changes_nothing() -> None:
    future: Future[int] = Future()
    future.set_result(1)
    future.cancel()
    assert (future.done(), future.cancelled()) == (True, False)


class Foreign:
    """An executor of somebody else's: all that rclpy asks of one is create_task."""

    def __init__(self) -> None:
        self.tasks: list[tuple[Callable[..., object], tuple[object, ...]]] = []

    def create_task(self, callback: Callable[..., object], *args: object) -> None:
        self.tasks.append((callback, args))


def test_done_callbacks_go_to_whatever_executor_makes_tasks() -> None:
    executor = Foreign()
    future: Future[int] = Future(executor=executor)
    seen: list[object] = []
    future.add_done_callback(seen.append)
    future.set_result(1)
    future.add_done_callback(seen.append)
    assert executor.tasks == [(seen.append, (future,))] * 2
    assert seen == []
    other: Future[int] = Future()
    other._set_executor(executor)
    other.add_done_callback(seen.append)
    other.cancel()
    assert executor.tasks[2:] == [(seen.append, (other,))]


def test_done_callbacks_without_an_executor_run_at_once_and_in_order() -> None:
    future: Future[int] = Future()
    seen: list[object] = []
    future.add_done_callback(seen.append)
    future.add_done_callback(lambda _: seen.append('b'))
    future.set_result(5)
    assert seen == [future, 'b']
    future.add_done_callback(lambda _: seen.append('late'))
    assert seen == [future, 'b', 'late']


def test_cancelling_calls_the_done_callbacks() -> None:
    future: Future[int] = Future()
    seen: list[object] = []
    future.add_done_callback(seen.append)
    future.cancel()
    assert seen == [future]


def test_a_done_callback_that_raises_is_a_warning_when_set_and_an_exception_when_added_late() -> None:
    future: Future[int] = Future()
    future.add_done_callback(lambda _: 1 / 0)
    with pytest.warns(UserWarning, match='Unhandled exception in done callback: division by zero'):
        future.set_result(1)
    assert future.done()
    with pytest.raises(ZeroDivisionError):
        future.add_done_callback(lambda _: 1 / 0)
    with pytest.raises(TypeError, match="'NoneType' object is not callable"):
        future.add_done_callback(None)  # type: ignore[arg-type]


def test_done_callbacks_of_an_executors_future_run_when_it_spins_in_order(
    single: SingleThreadedExecutor,
) -> None:
    future: Future[int] = Future(executor=single)
    seen: list[int] = []
    for number in range(4):
        future.add_done_callback(lambda _, number=number: seen.append(number))  # type: ignore[misc]
    future.set_result(1)
    assert seen == []
    for _ in range(4):
        single.spin_once(0)
    assert seen == [0, 1, 2, 3]
    future.add_done_callback(lambda _: seen.append(4))
    assert seen[-1] == 3
    single.spin_once(0)
    assert seen[-1] == 4


def test_done_callbacks_of_a_nodes_future_wait_for_the_node_to_be_spun(
    single: SingleThreadedExecutor, node: SmallNode
) -> None:
    future: Future[int] = Future(node.work_queue)
    seen: list[str] = []
    future.add_done_callback(lambda _: seen.append(threading.current_thread().name))
    thread = threading.Thread(target=future.set_result, args=(1,))
    thread.start()
    thread.join(PATIENCE)
    assert seen == []
    single.add_node(node)
    single.spin_once(0)
    assert seen == [threading.current_thread().name]


def test_an_exception_nobody_asked_for_is_printed_when_the_future_goes(
    capfd: pytest.CaptureFixture[str],
) -> None:
    future: Future[int] = Future()
    future.set_exception(ValueError('never retrieved'))
    del future
    gc.collect()
    assert 'The following exception was never retrieved: never retrieved' in capfd.readouterr().err


def test_an_exception_that_was_asked_for_is_not_printed(capfd: pytest.CaptureFixture[str]) -> None:
    future: Future[int] = Future()
    future.set_exception(ValueError('seen'))
    future.exception()
    del future
    gc.collect()
    assert capfd.readouterr().err == ''


def test_raw_results_are_decoded_once_and_only_when_asked_for() -> None:
    future = Decoded()
    before = Decoded.decoded
    future.set_raw('42')
    assert future.done()
    assert Decoded.decoded == before
    assert (future.result(), future.result()) == (42, 42)
    assert Decoded.decoded == before + 1


def test_set_raw_tells_whether_anybody_waited() -> None:
    assert not Future[object]().set_raw(b'x')
    watched = Future[object]()
    watched.add_waker(lambda: None)
    assert watched.set_raw(b'x')
    listened = Future[object]()
    listened.add_done_callback(lambda _: None)
    assert listened.set_raw(b'x')
    left = Future[object]()
    left.add_waker(print)
    left.remove_waker(print)
    assert not left.set_raw(b'x')


def test_raw_results_that_do_not_decode_are_the_futures_exception() -> None:
    future = Decoded()
    future.set_raw('no number')
    assert isinstance(future.exception(), ValueError)
    with pytest.raises(ValueError, match='no number'):
        future.result()


def test_two_threads_that_decode_one_raw_result_at_once_get_the_same() -> None:
    class Upper(Future[str]):
        asked = True

        def decode(self, raw: object, /) -> str:
            assert isinstance(raw, str)
            if self.asked:  # the other thread is quicker
                self.asked = False
                other = threading.Thread(target=lambda: results.append(self.result()))
                other.start()
                other.join(PATIENCE)
            return raw.upper()

    results: list[str | None] = []
    future = Upper()
    future.set_raw('x')
    results.append(future.result())
    assert results == ['X', 'X']
    assert results[0] is results[1]
    assert future.exception() is None


def test_wait_needs_no_executor() -> None:
    future: Future[int] = Future()
    timer = threading.Timer(0.02, future.set_result, (1,))
    timer.start()
    assert future.wait(in_10_s())
    assert future.result() == 1
    timer.join()


def test_wait_ends_at_its_deadline() -> None:
    future: Future[int] = Future()
    assert not future.wait(STEADY.now() + 10_000_000)
    assert future._wakers == []


def test_wait_ends_with_the_lifeline() -> None:
    future: Future[int] = Future()
    shutdown_signal = ShutdownSignal()
    timer = threading.Timer(0.02, shutdown_signal.end, ('test',))
    timer.start()
    deadline = in_10_s()
    assert not future.wait(deadline, shutdown_signal=shutdown_signal)
    assert STEADY.now() < deadline
    timer.join()


class Falling(SteadyClock):
    """Something happens as soon as somebody sleeps."""

    def __init__(self, happens: Callable[[], object]) -> None:
        self._happens = happens

    def wait(self, waiter: Sleeper, deadline_ns: int | None) -> bool:
        self._happens()
        return super().wait(waiter, deadline_ns)


def test_who_waits_one_after_the_other_sleeps_in_one_place() -> None:
    shutdown_signal, deadline = ShutdownSignal(), in_10_s()
    for _ in range(3):
        future: Future[int] = Future()
        clock = Falling(lambda: future.set_result(1))  # noqa: B023 - it is over before the next round
        assert future.wait(deadline, clock=clock, shutdown_signal=shutdown_signal)
        assert future._wakers == []
        (waiter,) = shutdown_signal.idle_waiters
        waiter.wake()  # as who was late to wake the last one: it ends the next wait no earlier
    assert STEADY.now() < deadline


def test_a_signal_handler_that_waits_takes_nothing_from_the_wait_that_it_interrupts() -> None:
    shutdown_signal, outer, inner, deadline = ShutdownSignal(), Future[int](), Future[int](), in_10_s()

    def handler(*_: object) -> None:
        outer.set_result(1)
        assert inner.wait(
            deadline, clock=Falling(lambda: inner.set_result(2)), shutdown_signal=shutdown_signal
        )

    before = signal.signal(signal.SIGUSR1, handler)
    try:
        clock = Falling(lambda: os.kill(os.getpid(), signal.SIGUSR1))
        assert outer.wait(deadline, clock=clock, shutdown_signal=shutdown_signal)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert STEADY.now() < deadline
    assert (outer.result(), inner.result()) == (1, 2)
    assert len(shutdown_signal.idle_waiters) == 2


def test_a_waker_added_to_a_settled_future_is_called_at_once() -> None:
    future: Future[int] = Future()
    future.set_result(1)
    called: list[int] = []
    future.add_waker(lambda: called.append(1))
    assert called == [1]


def test_completion_never_misses_a_thread_that_begins_to_wait() -> None:
    for _ in range(2000):
        future: Future[int] = Future()
        thread = threading.Thread(target=future.set_result, args=(1,))
        thread.start()
        assert future.wait(in_10_s())
        thread.join()


def test_a_coroutine_of_another_asyncio_loop_awaits_a_future_completed_on_a_thread() -> None:
    async def main() -> int | None:
        future: Future[int] = Future()
        thread = threading.Thread(target=future.set_result, args=(7,))
        thread.start()
        result = await future
        thread.join()
        return result

    assert asyncio.run(main()) == 7


def test_a_thousand_awaited_futures_wake_a_foreign_loop_in_few_turns() -> None:
    async def main() -> tuple[int, int]:
        loop = asyncio.get_running_loop()
        futures: list[Future[int]] = [Future() for _ in range(1000)]
        woken = 0
        real = loop.call_soon_threadsafe

        def counted(*args: object, **kwargs: object) -> asyncio.Handle:
            nonlocal woken
            woken += 1
            return real(*args, **kwargs)  # type: ignore[arg-type]

        loop.call_soon_threadsafe = counted  # type: ignore[method-assign]

        async def take(future: Future[int]) -> int:
            return await future or 0

        tasks = [asyncio.create_task(take(future)) for future in futures]
        await asyncio.sleep(0)
        for number, future in enumerate(futures):
            future.set_result(number)
        return sum(await asyncio.gather(*tasks)), woken

    total, woken = asyncio.run(main())
    assert total == sum(range(1000))
    assert woken == 1


def test_an_abandoned_await_leaves_no_waker_behind() -> None:
    future: Future[int] = Future()

    async def main() -> None:
        for _ in range(3):
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.001):
                    await future

    asyncio.run(main())
    assert future._wakers == []


def test_completing_a_future_whose_loop_is_closed_harms_nobody() -> None:
    future: Future[int] = Future()

    async def main() -> None:
        _ = asyncio.get_running_loop().create_task(take())
        await asyncio.sleep(0)

    async def take() -> None:
        await future

    asyncio.run(main())
    future.set_result(1)
    assert future.result() == 1


def test_awaiting_a_cancelled_future_gives_none(executor: Executor) -> None:
    future: Future[int] = Future()

    async def take() -> object:
        return ('got', await future)

    task = executor.create_task(take)
    executor.spin_once(0)
    future.cancel()
    executor.spin_until_future_complete(task, PATIENCE)
    assert task.result() == ('got', None)


def test_an_awaited_exception_is_raised_in_the_coroutine(executor: Executor) -> None:
    future: Future[int] = Future()

    async def take() -> str:
        try:
            await future
        except ValueError as error:
            return str(error)
        return 'nothing'

    task = executor.create_task(take)
    timer = threading.Timer(0.01, future.set_exception, (ValueError('fx'),))
    timer.start()
    executor.spin_until_future_complete(task, PATIENCE)
    timer.join()
    assert task.result() == 'fx'


def test_memory_is_flat_after_100_000_futures(context: SmallContext) -> None:
    shutdown_signal, deadline = context.shutdown_signal, in_10_s()

    def cycle(count: int) -> None:
        for number in range(count):
            future: Future[int] = Future()
            future.add_done_callback(lambda _: None)
            future.set_result(number)
            future.wait(deadline, shutdown_signal=shutdown_signal)

    cycle(1000)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        cycle(100_000)
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert after - before < 50_000
    assert not shutdown_signal._watchers


def test_a_callback_added_while_another_thread_completes_is_called_exactly_once() -> None:
    for _ in range(1000):
        future: Future[int] = Future()
        called: list[int] = []
        both = threading.Barrier(2, timeout=PATIENCE)

        def complete(future: Future[int] = future, both: threading.Barrier = both) -> None:
            both.wait()
            future.set_result(1)

        thread = threading.Thread(target=complete)
        thread.start()
        both.wait()
        future.add_done_callback(lambda _, called=called: called.append(1))  # type: ignore[misc]
        thread.join()
        assert called == [1]
