from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import PATIENCE, soon, wait_for

from goalwire.errors import InvalidHandle, ROSInterruptException
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from goalwire.execution.executors.executor import Executor
from goalwire.execution.executors.multi_threaded import MultiThreadedExecutor
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.time.clock import Clock, ROSClock
from goalwire.execution.time.steady_clock import STEADY, Sleeper, SteadyClock
from goalwire.execution.time.timer import Rate, Timer, TimerInfo, adapt_to_info
from goalwire.rules.time import ClockType, Duration, Time

if TYPE_CHECKING:
    from collections.abc import Callable

MS = 1_000_000


class HandSet(SteadyClock):
    """Time that a test moves; nobody sleeps in it."""

    __slots__ = ('offset', 'time')

    def __init__(self) -> None:
        self.time = 10**12
        self.offset = 10**18

    def now(self) -> int:
        return self.time

    def system_now(self) -> int:
        return self.time + self.offset

    def wait(self, waiter: Sleeper, deadline_ns: int | None) -> bool:
        raise AssertionError('a test with time set by hand must not sleep')


class World:
    """An executor, a node and timers, all in time set by hand."""

    def __init__(self) -> None:
        self.time = HandSet()
        context = SmallContext()
        context.shutdown_signal.clock = self.time
        self.executor = SingleThreadedExecutor(context=context)
        self.node = SmallNode()
        self.executor.add_node(self.node)
        self.calls: list[float] = []
        self.timers: list[Timer] = []
        """They live as long as somebody holds them."""
        self._begun = self.time.time

    def timer(
        self, period_ms: float, clock_type: ClockType = ClockType.ROS_TIME, *, autostart: bool = True
    ) -> Timer:
        clock = Clock(clock_type=clock_type, source=self.time)
        timer = Timer(
            self.note, None, int(period_ms * MS), clock, work_queue=self.node.work_queue, autostart=autostart
        )
        self.timers.append(timer)
        return timer

    def note(self) -> None:
        self.calls.append((self.time.time - self._begun) / MS)

    def at(self, ms: float, turns: int = 1) -> list[float]:
        """Move to `ms` after the beginning, spin, and return the times of all calls up to then."""
        self.time.time = self._begun + int(ms * MS)
        for _ in range(turns):
            self.executor.spin_once(0)
        return self.calls


@pytest.mark.parametrize('clock_type', [ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME])
def test_a_timer_is_called_once_a_period(clock_type: ClockType) -> None:
    world = World()
    timer = world.timer(100, clock_type)
    assert world.at(99) == []
    assert not timer.is_ready()
    world.time.time += 2 * MS
    assert timer.is_ready()
    assert (timer.time_until_next_call() or 0) < 0
    assert world.at(101, 3) == [101]
    assert world.at(200) == [101, 200]


def test_missed_periods_are_one_call_and_the_phase_is_kept() -> None:
    world = World()
    timer = world.timer(100)
    assert world.at(550, 3) == [550]
    assert timer.time_until_next_call() == 50 * MS
    assert timer.time_since_last_call() == 0


def test_the_rhythm_does_not_drift() -> None:
    world = World()
    timer = world.timer(10)
    for tick in range(1, 1000):
        world.at(tick * 10 + 3)
    assert timer.next_call_ns == world.time.system_now() - 3 * MS + 10 * MS
    assert len(world.calls) == 999


def test_a_canceled_timer_is_silent_until_reset() -> None:
    world = World()
    timer = world.timer(100)
    timer.cancel()
    assert timer.is_canceled()
    assert timer.time_until_next_call() is None
    assert world.at(300, 2) == []
    assert not timer.is_ready()
    timer.reset()
    assert not timer.is_canceled()
    assert timer.time_until_next_call() == 100 * MS
    assert world.at(399) == []
    assert world.at(400) == [400]


@pytest.mark.parametrize('period_ms', [10, 500])
def test_a_timer_reset_while_its_node_is_in_no_executor_is_called_in_time(period_ms: int) -> None:
    """As between two calls of `rclpy.spin_once(node)`."""
    world = World()
    timer = world.timer(100)
    assert world.at(50) == []
    world.executor.remove_node(world.node)
    timer.timer_period_ns = period_ms * MS
    timer.reset()
    world.executor.add_node(world.node)
    assert world.at(50 + period_ms - 1, 2) == []
    assert world.at(50 + period_ms, 2) == [50 + period_ms]
    assert world.at(50 + 2 * period_ms, 2) == [50 + period_ms, 50 + 2 * period_ms]


def test_without_autostart_it_waits_for_reset() -> None:
    world = World()
    timer = world.timer(100, autostart=False)
    assert (timer.is_canceled(), timer.is_ready(), timer.time_until_next_call()) == (True, False, None)
    timer.reset()
    assert world.at(100) == [100]


def test_a_new_period_counts_from_the_next_call_on() -> None:
    world = World()
    timer = world.timer(200)
    timer.timer_period_ns = 1000 * MS
    assert timer.timer_period_ns == 1000 * MS
    assert timer.time_until_next_call() == 200 * MS
    assert world.at(200) == [200]
    assert timer.time_until_next_call() == 1000 * MS
    timer.timer_period_ns = 1.5  # type: ignore[assignment]
    assert timer.timer_period_ns == 1
    timer.timer_period_ns = -5
    assert timer.timer_period_ns == -5
    with pytest.raises(ValueError, match='invalid literal for int'):
        timer.timer_period_ns = 'x'  # type: ignore[assignment]


def test_a_zero_period_is_due_each_turn_and_starves_nobody() -> None:
    world = World()
    world.timer(0)
    other = world.timer(10)
    world.at(0, 3)
    assert len(world.calls) == 3
    world.at(10, 4)
    assert other.time_since_last_call() == 0


def test_a_timer_may_cancel_or_destroy_itself_in_its_callback() -> None:
    for end in (Timer.cancel, Timer.destroy):
        world = World()
        timer = world.timer(100)
        timer.callback = lambda end=end, timer=timer, world=world: (world.note(), end(timer))
        assert world.at(100, 2) == [100]
        assert world.at(500, 2) == [100]


def test_a_destroyed_timer_raises_invalid_handle() -> None:
    world = World()
    timer = world.timer(100)
    timer.destroy()
    timer.destroy()
    assert timer.clock is not None
    for use in (timer.is_ready, timer.cancel, timer.reset, timer.is_canceled, timer.time_since_last_call):
        with pytest.raises(InvalidHandle, match='cannot use Destroyable'):
            use()
    with pytest.raises(InvalidHandle):
        _ = timer.timer_period_ns
    with pytest.raises(InvalidHandle):
        _ = timer.handle


def test_a_timer_that_is_destroyed_while_it_sets_its_entry_leaves_none_behind(node: SmallNode) -> None:
    class Interrupted(Clock):
        def steady_time_of(self, time_ns: int) -> int:
            if timers:
                timers.pop().destroy()  # as another thread may, right now
            return super().steady_time_of(time_ns)

    timers: list[Timer] = []
    timer = Timer(
        bool, None, MS, Interrupted(clock_type=ClockType.STEADY_TIME), work_queue=node.handle.work_queue
    )
    timers.append(timer)
    timer.reset()
    assert node.handle.work_queue._timer_entries == {}


def test_a_period_beyond_64_bits_is_refused() -> None:
    with pytest.raises(TypeError, match='does not fit into 64 bits'):
        World().timer(1e19)


def test_a_timer_without_a_callback_raises_as_in_rclpy() -> None:
    world = World()
    world.timer(100).callback = None
    with pytest.raises(TypeError, match="'NoneType' object is not callable"):
        world.at(100)


def test_a_failing_timer_goes_on_ticking() -> None:
    world = World()

    def fails() -> None:
        world.note()
        raise ValueError('boom')

    world.timer(100).callback = fails
    for tick in (100, 200, 300):
        with pytest.raises(ValueError, match='boom'):
            world.at(tick)
    assert world.calls == [100, 200, 300]


def test_two_due_timers_are_called_in_the_order_of_their_times() -> None:
    world = World()
    order: list[str] = []
    for name, period in (('late', 60), ('early', 50)):
        world.timer(period).callback = lambda name=name: order.append(name)
    world.at(100, 4)
    assert order == ['early', 'late']


def test_timers_tick_on_the_machines_time_under_both_executors(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    count = 0
    enough = threading.Event()

    def tick() -> None:
        nonlocal count
        count += 1
        if count == 20:
            enough.set()

    begun = STEADY.now()
    timer = Timer(tick, MutuallyExclusiveCallbackGroup(), 5 * MS, ROSClock(), work_queue=node.work_queue)
    with Spinning(executor):
        assert soon(enough)
        assert (STEADY.now() - begun) >= 100 * MS
    timer.destroy()


def test_a_timer_made_or_reset_while_the_executor_sleeps_is_heard_of(
    executor: Executor, node: SmallNode
) -> None:
    executor.add_node(node)
    distant = Timer(lambda: None, None, 3600 * 1000 * MS, Clock(), work_queue=node.work_queue)
    with Spinning(executor):
        assert executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        made = threading.Event()
        timer = Timer(made.set, None, 5 * MS, Clock(), work_queue=node.work_queue)
        assert soon(made)
        timer.destroy()
        reset = threading.Event()
        distant.callback = reset.set
        distant.timer_period_ns = 5 * MS
        distant.reset()
        assert soon(reset)
    distant.destroy()


def test_a_slow_reentrant_timer_overlaps_itself(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    multi.add_node(node)
    together = threading.Barrier(2, timeout=PATIENCE)
    met = threading.Event()

    def tick() -> None:
        with suppress(threading.BrokenBarrierError):  # a third one may come
            together.wait(PATIENCE)
            met.set()

    timer = Timer(tick, ReentrantCallbackGroup(), 5 * MS, Clock(), work_queue=node.work_queue)
    with Spinning(multi):
        assert soon(met)
        timer.cancel()
        together.abort()


def test_a_coroutine_timer_ticks_under_both_executors(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    count = 0
    enough = threading.Event()

    async def tick() -> None:
        nonlocal count
        await asyncio.sleep(0.001)  # half a period
        count += 1
        if count == 10:
            enough.set()

    timer = Timer(tick, MutuallyExclusiveCallbackGroup(), 2 * MS, Clock(), work_queue=node.work_queue)
    with Spinning(executor):
        assert soon(enough)
    timer.destroy()


def test_timers_tick_while_other_callbacks_block(multi: MultiThreadedExecutor, node: SmallNode) -> None:
    multi.add_node(node)
    release, ticked = threading.Event(), threading.Semaphore(0)
    timers = [
        Timer(callback, MutuallyExclusiveCallbackGroup(), 2 * MS, Clock(), work_queue=node.work_queue)
        for callback in (lambda: release.wait(PATIENCE), ticked.release)
    ]
    with Spinning(multi):
        for _ in range(10):
            assert ticked.acquire(timeout=PATIENCE)
        release.set()
        for timer in timers:
            timer.cancel()


# -- ROS time


def ros_seconds(world: World, clock: ROSClock, seconds: float) -> list[float]:
    clock.set_ros_time_override(Time(seconds=seconds, clock_type=ClockType.ROS_TIME))
    world.executor.spin_once(0)
    return world.calls


def test_a_timer_under_sim_time_follows_the_override() -> None:
    world = World()
    clock = cast('ROSClock', Clock(clock_type=ClockType.ROS_TIME, source=world.time))
    clock.set_ros_time_override(Time(seconds=10, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(True)
    timer = Timer(
        lambda: world.calls.append(clock.now().nanoseconds / 1e9),
        None,
        10**9,
        clock,
        work_queue=world.node.work_queue,
    )
    steps = [
        (10.5, [], 0.5),
        (11.0, [11.0], 1.0),
        (11.2, [11.0], 0.8),
        (14.5, [11.0, 14.5], 0.5),
        (14.9, [11.0, 14.5], 0.1),
        (15.0, [11.0, 14.5, 15.0], 1.0),
        (9.0, [11.0, 14.5, 15.0], 1.0),
        (9.5, [11.0, 14.5, 15.0], 0.5),
        (10.0, [11.0, 14.5, 15.0, 10.0], 1.0),
    ]
    for time, calls, until_next in steps:
        assert ros_seconds(world, clock, time) == calls
        assert (timer.time_until_next_call() or 0) / 1e9 == pytest.approx(until_next)


def test_a_timer_keeps_what_is_left_of_its_period_when_sim_time_is_switched() -> None:
    world = World()
    clock = ROSClock(source=world.time)
    timer = Timer(world.note, None, 100 * MS, clock, work_queue=world.node.work_queue)
    world.at(60)
    clock.set_ros_time_override(Time(seconds=5, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(True)
    assert timer.time_until_next_call() == 40 * MS
    assert world.at(10_000) == []
    clock.set_ros_time_override(Time(seconds=5.03, clock_type=ClockType.ROS_TIME))
    clock._set_ros_time_is_active(False)
    assert timer.time_until_next_call() == 10 * MS
    assert world.at(10_010) == [10_010]


def test_the_setter_of_sim_time_wakes_a_sleeping_executor(executor: Executor, node: SmallNode) -> None:
    executor.add_node(node)
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    ticked = threading.Event()
    timer = Timer(ticked.set, None, 10**9, clock, work_queue=node.work_queue)
    with Spinning(executor):
        assert executor.create_task(lambda: None).wait(STEADY.now() + 10**10)
        clock.set_ros_time_override(Time(seconds=1, clock_type=ClockType.ROS_TIME))
        assert soon(ticked)
    timer.destroy()


@pytest.mark.parametrize('clock_type', [ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME])
@pytest.mark.parametrize('seconds', [-3600, -0.15, 3600])
def test_a_timer_goes_on_when_the_machines_clock_is_set(clock_type: ClockType, seconds: float) -> None:
    world = World()
    timer = world.timer(100, clock_type)
    assert world.at(100) == [100]
    world.at(140)
    world.time.offset += int(seconds * 1e9)
    before = timer.time_until_next_call()
    assert before is not None
    if seconds < 0:
        assert before == 60 * MS  # the running period ends in its time
        assert not timer.is_ready()
    for ms in range(141, 500):
        world.at(ms)
    assert len(world.calls) == 4
    assert all(100 * number <= at < 100 * number + 100 for number, at in enumerate(world.calls, 1))
    assert 0 <= timer.time_since_last_call() < 100 * MS
    following = timer.time_until_next_call()
    assert following is not None
    assert 0 < following <= 100 * MS


def test_a_timer_whose_clock_is_set_back_within_a_period_waits_that_much_longer() -> None:
    world = World()
    world.timer(100)
    world.at(100)
    world.at(180)
    world.time.offset -= 50 * MS
    for ms in range(181, 700):
        world.at(ms)
    assert world.calls == [100, 250, 350, 450, 550, 650]


def test_a_timer_that_is_reset_after_its_clock_was_set_back_begins_a_new_period() -> None:
    world = World()
    timer = world.timer(100)
    world.at(100)
    world.time.offset -= 3600 * 1000 * MS
    world.at(130)
    timer.reset()
    assert timer.time_until_next_call() == 100 * MS
    assert world.at(229) == [100]
    assert world.at(230) == [100, 230]


# -- Rate


class Adjustable(SteadyClock):
    """The machine's time, with a system clock that a test sets."""

    __slots__ = ('shift',)

    def __init__(self) -> None:
        self.shift = 0

    def system_now(self) -> int:
        return STEADY.system_now() + self.shift


def test_a_rate_and_a_sleep_end_in_time_when_the_machines_clock_is_set_back(context: SmallContext) -> None:
    time = Adjustable()
    context.shutdown_signal.clock = time
    clock = ROSClock(source=time)
    ticks = rate(context, 10, clock)
    ended = threading.Semaphore(0)

    def sleep(how: Callable[[], object]) -> None:
        for _ in range(3):
            how()
            ended.release()

    threads = [
        threading.Thread(target=sleep, args=(how,))
        for how in (ticks.sleep, lambda: clock.sleep_for(Duration(nanoseconds=100 * MS), context))
    ]
    for thread in threads:
        thread.start()
    assert ended.acquire(timeout=PATIENCE)
    time.shift = -3600 * 1000 * MS
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()


class SetBackAtOnce(Adjustable):
    """A system clock that is set back by an hour as soon as it has been read."""

    __slots__ = ()

    def system_now(self) -> int:
        now = super().system_now()
        self.shift = -3600 * 1000 * MS
        return now


def test_a_sleep_ends_in_time_if_the_clock_is_set_back_as_it_begins(context: SmallContext) -> None:
    context.shutdown_signal.clock = time = SetBackAtOnce()
    clock = ROSClock(source=time)
    assert in_thread(lambda: clock.sleep_for(Duration(nanoseconds=10 * MS), context)).wait(PATIENCE)


def sim(seconds: float) -> Time:
    return Time(seconds=seconds, clock_type=ClockType.ROS_TIME)


def in_thread(work: Callable[[], object]) -> threading.Event:
    """Do it in a thread of its own; the event tells its end."""
    ended = threading.Event()

    def run() -> None:
        work()
        ended.set()

    threading.Thread(target=run).start()
    return ended


def rate(context: SmallContext, hertz: float, clock: Clock | None = None) -> Rate:
    return Rate(Timer(None, None, int(1e9 / hertz), clock or ROSClock()), context=context)


def test_a_rate_sleeps_for_its_period_without_an_executor(context: SmallContext) -> None:
    begun = STEADY.now()  # before the rate is made: its periods count from there
    ticks = rate(context, 50)
    ticks.sleep()
    ticks.sleep()
    assert 40 * MS <= STEADY.now() - begun < PATIENCE * 1e9


def test_a_destroyed_rate_says_so_and_wakes_its_sleeper(context: SmallContext) -> None:
    ticks = rate(context, 0.001)
    timer = threading.Timer(0.02, ticks.destroy)
    timer.start()
    with pytest.raises(RuntimeError, match='Rate cannot sleep because it has been destroyed'):
        ticks.sleep()
    timer.join()
    with pytest.raises(RuntimeError, match='destroyed'):
        ticks.sleep()


def test_shutdown_interrupts_a_rate(context: SmallContext) -> None:
    ticks = rate(context, 0.001)
    timer = threading.Timer(0.02, context.shutdown)
    timer.start()
    with pytest.raises(ROSInterruptException, match=r'rclpy.shutdown\(\) has been called'):
        ticks.sleep()
    timer.join()


def test_two_threads_share_the_ticks_of_a_rate(context: SmallContext) -> None:
    begun = STEADY.now()
    ticks = rate(context, 100)

    def sleep() -> None:
        for _ in range(3):
            ticks.sleep()

    threads = [threading.Thread(target=sleep) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
        assert not thread.is_alive()
    assert STEADY.now() - begun >= 30 * MS


def test_a_rate_on_sim_time_wakes_with_the_clock(context: SmallContext) -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    ends = []
    for hertz in (1, 2):
        ends.append(in_thread(rate(context, hertz, clock).sleep))
        wait_for(lambda: len(clock._sleepers) == len(ends), 'the sleep to begin')
    whole, half = ends
    clock.set_ros_time_override(Time(seconds=0.5, clock_type=ClockType.ROS_TIME))
    assert soon(half)
    assert not whole.is_set()
    clock.set_ros_time_override(Time(seconds=1, clock_type=ClockType.ROS_TIME))
    assert soon(whole)


def test_a_rate_goes_on_when_its_clock_is_switched_and_jumps_back(context: SmallContext) -> None:
    clock = ROSClock()
    ticks = rate(context, 0.001, clock)
    count = threading.Semaphore(0)

    def sleep() -> None:
        for _ in range(2):
            ticks.sleep()
            count.release()

    thread = threading.Thread(target=sleep)
    thread.start()
    wait_for(lambda: clock._sleepers, 'the sleep to begin')

    def other_sleeps_until(seconds: float) -> threading.Event:
        before = len(clock._sleepers)
        ended = in_thread(lambda: clock.sleep_until(sim(seconds), context))
        wait_for(lambda: len(clock._sleepers) > before, 'the sleep to begin')
        return ended

    other = other_sleeps_until(4_000_000_000)  # the clock shows the time of day
    clock.set_ros_time_override(sim(5000))
    clock._set_ros_time_is_active(True)
    assert soon(other)
    assert not count.acquire(blocking=False), 'being switched is no tick'
    clock.set_ros_time_override(sim(100))
    other = other_sleeps_until(1099)
    clock.set_ros_time_override(sim(1099))
    assert soon(other)
    assert not count.acquire(blocking=False), 'a jump back begins a new period'
    for seconds in (1100, 2100):
        clock.set_ros_time_override(sim(seconds))
        assert count.acquire(timeout=PATIENCE)
    thread.join()


def test_a_loop_around_spin_once_goes_on_while_another_thread_sleeps_in_a_rate(
    executor: Executor, context: SmallContext, node: SmallNode
) -> None:
    executor.add_node(node)
    ticks = Rate(Timer(None, None, 10 * MS, ROSClock(), work_queue=node.work_queue), context=context)
    done = threading.Event()

    def source() -> None:
        for _ in range(3):
            ticks.sleep()
        done.set()

    def loop() -> None:
        while not done.is_set():
            executor.spin_once()

    threads = [threading.Thread(target=target) for target in (source, loop)]
    for thread in threads:
        thread.start()
    try:
        for thread in threads:
            thread.join(PATIENCE)
            assert not thread.is_alive()
    finally:
        context.shutdown()
        for thread in threads:
            thread.join()


@pytest.mark.parametrize('late_ms', [-3, 0, 4, 10, 25])
def test_a_rate_has_a_turn_of_the_executor_in_each_period(late_ms: int) -> None:
    world = World()
    timer = world.timer(10)
    due = timer.next_call_ns
    timer.take_over()
    world.time.time += (10 + late_ms) * MS
    assert timer._schedule.next_turn() - due == max(0, late_ms // 10 + 1) * 10 * MS
    assert world.at(10.0 + late_ms) == []
    assert timer.next_call_ns == due  # whoever sleeps at this rhythm calls it


def test_what_is_no_clock_is_refused() -> None:
    with pytest.raises(AttributeError, match="'int' object has no attribute 'handle'"):
        Timer(None, None, 10**9, 1)  # type: ignore[arg-type]


class Robot:
    def nothing(self) -> None: ...
    def required(self, info: object) -> object:
        return info

    def annotated(self, how: int = 3, *, when: TimerInfo | None = None, info: TimerInfo) -> object:
        return (how, when, info)


class Callable0:
    def __call__(self) -> None: ...


class Callable1:
    def __call__(self, info: TimerInfo) -> TimerInfo:
        return info


def default(name: str = 'x') -> str:
    return name


def quoted(number: int = 1, info: 'TimerInfo | None' = None) -> None: ...  # noqa: UP037


def exact(number: int = 1, info: TimerInfo = TimerInfo()) -> object:  # noqa: B008
    return (number, info)


def anything(*args: object, **kwargs: object) -> None: ...


@pytest.mark.parametrize(
    'callback',
    [
        Robot().nothing,
        Callable0(),
        default,
        quoted,
        anything,
        print,
        partial(default, 'y'),
        lambda name='x': name,
        None,
        3,
    ],
)
def test_a_callback_that_asks_for_nothing_gets_nothing(callback: object) -> None:
    assert adapt_to_info(callback) is None


@pytest.mark.parametrize(
    ('callback', 'expected'),
    [
        (lambda info: info, lambda info: info),
        (Robot().required, lambda info: info),
        (Callable1(), lambda info: info),
        (exact, lambda info: (1, info)),
        (Robot().annotated, lambda info: (3, None, info)),
        (partial(Robot().annotated, 5), lambda info: (5, None, info)),
    ],
)
def test_a_callback_that_asks_gets_the_info(
    callback: object, expected: Callable[[TimerInfo], object]
) -> None:
    info = TimerInfo(expected_call_time=1, actual_call_time=2)
    given = adapt_to_info(callback)
    assert given is not None
    assert given(info) == expected(info)


def test_an_info_holds_times_of_the_clock() -> None:
    info = TimerInfo(expected_call_time=5, actual_call_time=7, clock_type=ClockType.ROS_TIME)
    assert info.expected_call_time == Time(nanoseconds=5, clock_type=ClockType.ROS_TIME)
    assert info.actual_call_time == Time(nanoseconds=7, clock_type=ClockType.ROS_TIME)


@pytest.mark.parametrize(
    ('arguments', 'error', 'message'),
    [
        ({'clock_type': 1}, TypeError, 'Clock type must be a ClockType enum'),
        ({'expected_call_time': -1}, ValueError, 'call time values must not be negative'),
        ({'actual_call_time': -1}, ValueError, 'call time values must not be negative'),
    ],
)
def test_an_info_of_impossible_times_is_refused(
    arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        TimerInfo(**arguments)


def test_a_timer_tells_when_it_was_due_and_when_it_came(context: SmallContext) -> None:
    node, clock, seen = SmallNode(), ROSClock(), list[TimerInfo]()
    clock._set_ros_time_is_active(True)
    timer = Timer(seen.append, None, 10**9, clock, work_queue=node.work_queue)
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        clock.set_ros_time_override(Time(seconds=2.5, clock_type=ClockType.ROS_TIME))
        executor.spin_once(0)
    timer.destroy()
    [info] = seen
    assert info.expected_call_time == Time(seconds=1, clock_type=ClockType.ROS_TIME)
    assert info.actual_call_time == Time(seconds=2.5, clock_type=ClockType.ROS_TIME)


def test_another_callback_may_ask_for_less() -> None:
    timer = Timer(lambda _: None, None, 10**9, Clock())
    assert timer._with_info is not None
    timer.callback = lambda: None
    assert timer._with_info is None
