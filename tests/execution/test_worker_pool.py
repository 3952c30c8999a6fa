from __future__ import annotations

import threading

import pytest
from helpers.collector import Collector
from helpers.execution import SmallContext, Spinning
from helpers.patience import PATIENCE, soon

from goalwire.execution.monotonic import STEADY
from goalwire.execution.multi_threaded import MultiThreadedExecutor, WorkerPool


def test_of_workers_that_ask_at_once_no_more_are_let_go_than_there_are_too_many() -> None:
    asking = threading.Barrier(5)
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
        """Its workers leave together where they can."""

        both = threading.Barrier(2)

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
