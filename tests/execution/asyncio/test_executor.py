"""A node's callbacks in an asyncio loop: order, groups, timers, errors, and the ways out."""

from __future__ import annotations

import asyncio
import os
import threading
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest
from helpers.execution import SmallContext, SmallNode
from helpers.loops import LOOPS, run, turns

from goalwire.execution.asyncio.executor import CallbackTasks, SharedLoop
from goalwire.execution.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from goalwire.execution.current_callback import active_executors, why_it_cannot_answer
from goalwire.execution.event_queue import EventQueue, GuardCondition
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
from goalwire.execution.time.clock import ROSClock
from goalwire.execution.time.steady_clock import STEADY
from goalwire.execution.time.timer import Timer


class World:
    """A context, a node, and things to happen in it."""

    def __init__(self) -> None:
        self.context = SmallContext()
        self.node = SmallNode()
        self.runs = CallbackTasks()
        self.host = SharedLoop(self.node.work_queue, self.context.shutdown_signal, self.runs)
        self.seen: list[Any] = []
        self.enough = asyncio.Event()
        self.wanted = 1

    def see(self, what: object) -> None:
        self.seen.append(what)
        if len(self.seen) >= self.wanted:
            self.enough.set()

    async def expect(self, count: int) -> list[Any]:
        self.wanted = count
        if len(self.seen) < count:
            self.enough.clear()
            await self.enough.wait()
        return self.seen

    def event_queue(
        self, handle: Callable[[Any], object], group: CallbackGroup | None = None
    ) -> EventQueue[Any]:
        return EventQueue(self.node.work_queue, group or MutuallyExclusiveCallbackGroup(), handle)

    def timer(self, period_ms: float, callback: Callable[[], object]) -> Timer:
        group = MutuallyExclusiveCallbackGroup()
        return Timer(callback, group, int(period_ms * 1e6), ROSClock(), work_queue=self.node.work_queue)


@pytest.fixture
def world() -> World:
    return World()


@pytest.mark.parametrize('loop', LOOPS)
def test_what_another_thread_posts_is_run_on_the_loops_thread_in_order(world: World, loop: str) -> None:
    threads: set[int] = set()

    def handle(event: int) -> None:
        threads.add(threading.get_ident())
        world.see(event)

    async def scenario() -> None:
        event_queue = world.event_queue(handle)
        async with world.host:
            thread = threading.Thread(target=lambda: list(map(event_queue.deliver, range(500))))
            thread.start()
            assert await world.expect(500) == list(range(500))
            thread.join()

    run(scenario(), loop)
    assert threads == {threading.get_ident()}


@pytest.mark.parametrize('has_eventfd', [True, False])
def test_a_burst_costs_one_wake_up(world: World, monkeypatch: pytest.MonkeyPatch, has_eventfd: bool) -> None:
    if not has_eventfd:
        monkeypatch.delattr(os, 'eventfd', raising=False)
    elif not hasattr(os, 'eventfd'):
        pytest.skip('this platform has none')

    async def scenario() -> int:
        loop = asyncio.get_running_loop()
        calls = 0

        def counting(wake: Callable[..., Any]) -> Callable[..., Any]:
            def counted(*args: Any, **kwargs: Any) -> Any:
                nonlocal calls
                calls += 1
                return wake(*args, **kwargs)

            return counted

        if has_eventfd:
            monkeypatch.setattr(os, 'eventfd_write', counting(os.eventfd_write))
        else:
            monkeypatch.setattr(loop, 'call_soon_threadsafe', counting(loop.call_soon_threadsafe))
        event_queues = [world.event_queue(world.see) for _ in range(10)]
        async with world.host:
            for event_queue in event_queues:
                event_queue.deliver(1)
            await world.expect(10)
            return calls

    assert run(scenario()) == 1


def test_what_came_before_the_block_is_run_in_it_and_nothing_after_it(world: World) -> None:
    async def scenario() -> None:
        event_queue = world.event_queue(world.see)
        event_queue.deliver('before')
        async with world.host:
            assert world.seen == []
            await world.expect(1)
        event_queue.deliver('after')
        await turns()
        assert world.seen == ['before']
        assert not world.node.work_queue.attached

    run(scenario())


def test_other_tasks_of_the_loop_have_their_turns_during_a_flood(world: World) -> None:
    async def scenario() -> None:
        def again(event: int) -> None:
            event_queue.deliver(event + 1)

        event_queue = world.event_queue(again)
        async with world.host:
            event_queue.deliver(0)
            for _ in range(100):
                await asyncio.sleep(0)
            assert len(event_queue) == 1, 'the flood goes on'

    run(scenario())


def test_a_coroutine_of_an_exclusive_group_holds_it_while_it_awaits(world: World) -> None:
    async def handle(event: int) -> None:
        world.see(('begin', event))
        await turns()
        world.see(('end', event))

    async def scenario() -> None:
        event_queue = world.event_queue(handle)
        async with world.host:
            event_queue.deliver(1)
            event_queue.deliver(2)
            assert await world.expect(4) == [('begin', 1), ('end', 1), ('begin', 2), ('end', 2)]

    run(scenario())


def test_coroutines_of_a_reentrant_group_run_beside_each_other(world: World) -> None:
    async def scenario() -> None:
        barrier = asyncio.Barrier(3)

        async def handle(event: int) -> None:
            await barrier.wait()
            world.see(event)

        event_queue = world.event_queue(handle, ReentrantCallbackGroup())
        async with world.host:
            for event in range(3):
                event_queue.deliver(event)
            assert sorted(await world.expect(3)) == [0, 1, 2]

    run(scenario())


@pytest.mark.parametrize('loop', LOOPS)
def test_a_timer_does_not_drift_and_is_never_early(world: World, loop: str) -> None:
    period = 5_500_000

    async def scenario() -> None:
        timer = world.timer(
            period / 1e6, lambda: world.see(STEADY.system_now() - timer.next_call_ns + period)
        )
        first = timer.next_call_ns
        async with world.host:
            lateness = await world.expect(10)
            assert min(lateness) >= 0
            assert (timer.next_call_ns - first) % period == 0, 'the phase is kept'
            timer.destroy()

    run(scenario(), loop)


def test_the_loops_timer_is_left_alone_while_the_next_due_time_stands(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> None:
        loop, set_timers = asyncio.get_running_loop(), 0
        call_later = loop.call_later

        def counted(*args: Any, **kwargs: Any) -> asyncio.TimerHandle:
            nonlocal set_timers
            set_timers += 1
            return call_later(*args, **kwargs)

        monkeypatch.setattr(loop, 'call_later', counted)
        late = world.timer(60_000, bool)
        event_queue = world.event_queue(world.see)
        async with world.host:
            for count in range(1, 10):
                event_queue.deliver(count)
                await world.expect(count)
            assert set_timers == 1
            late.destroy()

    run(scenario())


def test_a_tick_leaves_no_waker_behind(world: World) -> None:
    async def scenario() -> None:
        timer = world.timer(1, lambda: world.see('tick'))
        async with world.host:
            await world.expect(5)
            queue = world.node.work_queue.queue
            assert queue is not None
            assert queue.sleepers <= 1
            timer.destroy()

    run(scenario())


def test_a_timer_that_is_set_earlier_while_the_loop_sleeps_rings_in_time(world: World) -> None:
    async def scenario() -> None:
        late = world.timer(60_000, bool)
        async with world.host:
            await turns()  # the host has found nothing to do
            soon = await asyncio.to_thread(world.timer, 1, lambda: world.see('soon'))
            await world.expect(1)
            soon.destroy()
            late.destroy()

    run(scenario())


def test_an_async_timer_callback_that_is_late_is_called_once_for_what_it_missed(world: World) -> None:
    async def scenario() -> None:
        async def callback() -> None:
            world.see(STEADY.now())
            await asyncio.sleep(0.025)  # two and a half periods

        timer = world.timer(10, callback)
        async with world.host:
            times = await world.expect(3)
            assert all(after - before >= 25e6 for before, after in pairwise(times))
            timer.destroy()

    run(scenario())


def test_a_guard_condition_triggered_by_a_thread_is_served(world: World) -> None:
    async def scenario() -> None:
        guard = GuardCondition(lambda: world.see(1), None, work_queue=world.node.work_queue)
        async with world.host:
            await asyncio.to_thread(guard.trigger)
            await world.expect(1)

    run(scenario())


def _plain(world: World) -> Callable[[Any], object]:
    def handle(event: object) -> None:
        raise ValueError(event)

    return handle


def _coroutine(world: World) -> Callable[[Any], object]:
    async def handle(event: object) -> None:
        await asyncio.sleep(0)
        raise ValueError(event)

    return handle


@pytest.mark.parametrize('make', [_plain, _coroutine])
def test_an_error_of_a_callback_cancels_the_body_and_leaves_in_a_group(
    world: World, make: Callable[[World], Callable[[Any], object]]
) -> None:
    cancelled: list[str] = []

    async def other(_: object) -> None:
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            cancelled.append('other callback')
            raise

    async def scenario() -> None:
        failing, waiting = world.event_queue(make(world)), world.event_queue(other)
        waiting.deliver(1)
        failing.deliver('boom')
        failing.deliver('never seen')
        try:
            async with world.host:
                await asyncio.Event().wait()
        except BaseException:
            cancelled.append('body')
            raise

    with pytest.raises(ExceptionGroup) as raised:
        run(scenario())
    assert [(type(error), error.args) for error in raised.value.exceptions] == [(ValueError, ('boom',))]
    assert cancelled == ['other callback', 'body']


def test_no_callback_runs_once_one_has_failed(world: World) -> None:
    ticks = 0

    def tick() -> None:
        nonlocal ticks
        ticks += 1

    async def scenario(handle: Callable[[Any], object]) -> None:
        world = World()
        event_queue = world.event_queue(handle)
        timer = world.timer(0.5, tick)
        try:
            async with world.host:
                event_queue.deliver('boom')
                try:
                    await asyncio.Event().wait()
                finally:
                    before = ticks
                    while not timer.is_ready():  # noqa: ASYNC110 - nothing tells that it is due
                        await asyncio.sleep(0)
                    await turns()
                    assert ticks == before
        finally:
            assert not world.context.shutdown_signal._watchers

    for make in (_plain, _coroutine):
        with pytest.raises(ExceptionGroup) as raised:
            run(scenario(make(world)))
        assert [type(error) for error in raised.value.exceptions] == [ValueError]


def test_errors_while_callbacks_clean_up_are_in_the_group_too(world: World) -> None:
    begun = asyncio.Event()

    async def unclean(_: object) -> None:
        begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            raise KeyError('unclean')

    async def scenario() -> None:
        event_queue = world.event_queue(unclean)
        event_queue.deliver(1)
        async with world.host:
            await begun.wait()
            raise ValueError('body')

    with pytest.raises(ExceptionGroup) as raised:
        run(scenario())
    assert {type(error) for error in raised.value.exceptions} == {KeyError, ValueError}


def test_the_callbacks_of_a_failed_block_are_over_when_it_is_left(world: World) -> None:
    async def body() -> None:
        async with world.host:
            await asyncio.Event().wait()

    async def scenario() -> None:
        event_queue = world.event_queue(_plain(world))
        event_queue.deliver(1)
        with pytest.raises(ExceptionGroup):
            await body()
        assert active_executors.executors == []
        assert not world.host.running
        assert len(asyncio.all_tasks()) == 1

    run(scenario())


def test_leaving_the_block_cancels_callbacks_and_waits_for_their_cleaning_up(world: World) -> None:
    async def callback(_: object) -> None:
        world.see('begun')
        try:
            await asyncio.Event().wait()
        finally:
            await turns()
            world.see('cleaned up')

    async def scenario() -> None:
        event_queue = world.event_queue(callback)
        async with world.host:
            event_queue.deliver(1)
            await world.expect(1)
        assert world.seen == ['begun', 'cleaned up']
        assert len(world.runs) == 0

    run(scenario())


def test_cancelling_the_task_that_entered_ends_everything(world: World) -> None:
    async def callback(_: object) -> None:
        world.see('begun')
        try:
            await asyncio.Event().wait()
        finally:
            world.see('cancelled')

    async def body() -> None:
        async with world.host:
            await world.host.wait()

    async def scenario() -> None:
        world.event_queue(callback).deliver(1)
        task = asyncio.create_task(body())
        await world.expect(1)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert world.seen == ['begun', 'cancelled']

    run(scenario())


@pytest.mark.parametrize('loop', LOOPS)
def test_the_end_of_the_context_ends_the_wait_and_runs_nothing_more(world: World, loop: str) -> None:
    async def scenario() -> None:
        event_queue = world.event_queue(world.see)
        async with world.host:
            thread = threading.Thread(target=world.context.shutdown)
            thread.start()
            await world.host.wait()
            thread.join()
            event_queue.deliver(1)
            await turns()
        assert world.seen == []

    run(scenario(), loop)


def test_a_context_that_has_ended_before_ends_the_wait_at_once(world: World) -> None:
    async def scenario() -> None:
        world.context.shutdown()
        async with world.host:
            await world.host.wait()

    run(scenario())


def test_end_may_be_called_before_within_and_by_another_thread(world: World) -> None:
    async def scenario() -> None:
        async with world.host:
            thread = threading.Thread(target=world.host.end)
            thread.start()
            await world.host.wait()
            thread.join()
        early = World()
        early.host.end()
        async with early.host:
            await early.host.wait()

    run(scenario())
    world.host.end()  # the loop is closed


@pytest.mark.parametrize('error', [KeyboardInterrupt, SystemExit])
def test_an_interrupt_in_a_callback_leaves_the_loop_as_it_is(
    world: World, error: type[BaseException]
) -> None:
    def handle(_: object) -> None:
        raise error

    async def scenario() -> None:
        event_queue = world.event_queue(handle)
        async with world.host:
            event_queue.deliver(1)
            await asyncio.Event().wait()

    with pytest.raises(error):
        run(scenario())
    assert active_executors.executors == []


def test_many_hosts_share_a_loop(world: World) -> None:
    async def scenario() -> None:
        other = World()
        async with world.host, other.host:
            world.event_queue(other.see).deliver('to other')
            other.event_queue(world.see).deliver('to world')
            assert await other.expect(1) == ['to other']
            assert await world.expect(1) == ['to world']

    run(scenario())


def test_a_call_that_blocks_the_loop_on_its_own_node_is_told_apart(world: World) -> None:
    async def scenario() -> str | None:
        group = MutuallyExclusiveCallbackGroup()
        async with world.host:
            elsewhere = await asyncio.to_thread(why_it_cannot_answer, world.node.work_queue, group)
            assert elsewhere is None
            return why_it_cannot_answer(world.node.work_queue, group)

    reason = run(scenario())
    assert reason is not None
    assert 'the very thread' in reason
    assert why_it_cannot_answer(world.node.work_queue, None) is None


def test_cancelling_a_work_spares_others_and_the_caller() -> None:
    async def scenario() -> list[bool]:
        runs, one, other = (
            CallbackTasks(),
            CallbackSource(NodeWorkQueue(), None),
            CallbackSource(NodeWorkQueue(), None),
        )

        async def forever() -> None:
            await asyncio.Event().wait()

        async def canceller() -> None:
            runs.cancel(one)
            await asyncio.sleep(0)

        tasks = [asyncio.create_task(run) for run in (forever(), forever(), canceller())]
        for task, source in zip(tasks, (one, other, one), strict=True):
            runs.add(task, source)
        await tasks[2]
        cancelled = [task.cancelled() for task in tasks]
        for task in tasks:
            runs.discard(task)
        assert len(runs) == 0
        runs.cancel_all()
        tasks[1].cancel()
        return cancelled

    assert run(scenario()) == [True, False, False]


def test_nothing_runs_outside_a_loop_and_nothing_is_cancelled() -> None:
    runs = CallbackTasks()
    runs.cancel_all()  # asks asyncio for no task: there is no loop to ask
    assert len(runs) == 0
