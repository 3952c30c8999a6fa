from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from helpers.execution import SmallContext, SmallNode, Spinning
from helpers.patience import soon, wait_for

from goalwire.errors import NotInitializedException
from goalwire.execution.executors.single_threaded import SingleThreadedExecutor
from goalwire.execution.time.clock import (
    Clock,
    ClockChange,
    ClockTimerEntry,
    JumpThreshold,
    ROSClock,
    TimeJump,
)
from goalwire.execution.time.steady_clock import STEADY
from goalwire.rules.time import ClockType, Duration, Time

ROS, SYSTEM, STEADY_TIME = ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME


def ros(seconds: float) -> Time:
    return Time(seconds=seconds, clock_type=ROS)


def active(seconds: float = 0) -> ROSClock:
    clock = ROSClock()
    clock.set_ros_time_override(ros(seconds))
    clock._set_ros_time_is_active(True)
    return clock


def test_kinds_and_their_names() -> None:
    assert repr(Clock()) == 'Clock(clock_type=SYSTEM_TIME)'
    assert repr(Clock(clock_type=STEADY_TIME)) == 'Clock(clock_type=STEADY_TIME)'
    assert repr(Clock(clock_type=ClockType.UNINITIALIZED)) == 'Clock(clock_type=UNINITIALIZED)'
    assert repr(ROSClock()) == 'Clock(clock_type=ROS_TIME)'
    assert type(Clock(clock_type=ROS)) is ROSClock
    assert ROSClock().clock_type is ROS


@pytest.mark.parametrize('wrong', ['x', 1])
def test_what_is_no_clock_type_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError, match='Clock type must be a ClockType enum'):
        Clock(clock_type=wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize('kind', [ROS, SYSTEM, STEADY_TIME])
def test_now_is_of_the_clocks_type_and_moves_on(kind: ClockType) -> None:
    clock = Clock(clock_type=kind)
    first = clock.now()
    assert first.clock_type is kind
    assert clock.now() >= first


def test_ros_time_is_system_time_until_it_is_active() -> None:
    clock = ROSClock()
    assert (clock.ros_time_is_active, clock.overridden) == (False, False)
    clock.set_ros_time_override(ros(1))
    assert clock.now().nanoseconds > 10**18
    clock._set_ros_time_is_active(True)
    assert (clock.ros_time_is_active, clock.overridden) == (True, True)
    assert clock.now() == ros(1)
    clock._set_ros_time_is_active(False)
    assert clock.now().nanoseconds > 10**18


def test_only_a_time_can_be_set_and_only_on_ros_clocks() -> None:
    with pytest.raises(TypeError, match='Time must be specified as rclpy'):
        ROSClock().set_ros_time_override(1)  # type: ignore[arg-type]
    assert not hasattr(Clock(clock_type=SYSTEM), 'set_ros_time_override')


@pytest.mark.parametrize(
    ('forward', 'backward', 'on_change', 'message'),
    [
        (1, 1, True, 'min_backward must be a negative non-zero duration'),
        (None, 0, True, 'min_backward must be a negative non-zero duration'),
        (-1, None, True, 'min_forward must be a positive non-zero duration'),
        (None, None, False, 'At least one jump threshold must be enabled'),
    ],
)
def test_thresholds_that_mean_nothing_are_refused(
    forward: int | None, backward: int | None, on_change: bool, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        JumpThreshold(
            min_forward=None if forward is None else Duration(seconds=forward),
            min_backward=None if backward is None else Duration(seconds=backward),
            on_clock_change=on_change,
        )


def test_jump_callbacks_must_be_callable() -> None:
    threshold = JumpThreshold(min_forward=None, min_backward=None)
    with pytest.raises(ValueError, match='One of pre_callback or post_callback must be callable'):
        ROSClock().create_jump_callback(threshold)
    with pytest.raises(ValueError, match='pre_callback must be callable if given'):
        ROSClock().create_jump_callback(threshold, pre_callback=1)  # type: ignore[arg-type]


def test_jump_callbacks_see_the_time_before_and_after() -> None:
    clock = active(1)
    seen: list[object] = []

    def after(jump: TimeJump) -> None:
        seen.append((jump.clock_change, jump.delta.nanoseconds, clock.now().nanoseconds))

    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=Duration(seconds=-1))
    with clock.create_jump_callback(
        threshold, pre_callback=lambda: seen.append(clock.now().nanoseconds), post_callback=after
    ):
        clock.set_ros_time_override(ros(1.5))
        assert seen == []
        clock.set_ros_time_override(ros(3))
        assert seen == [1_500_000_000, (ClockChange.ROS_TIME_NO_CHANGE, 1_500_000_000, 3_000_000_000)]
        seen.clear()
        clock.set_ros_time_override(ros(1))
        assert seen == [3_000_000_000, (ClockChange.ROS_TIME_NO_CHANGE, -2_000_000_000, 1_000_000_000)]
        seen.clear()
        clock._set_ros_time_is_active(False)
        assert seen[0] == 1_000_000_000
    seen.clear()
    clock._set_ros_time_is_active(True)
    assert seen == []


def test_switching_is_only_told_to_those_who_asked() -> None:
    clock = ROSClock()
    seen: list[str] = []
    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=None, on_clock_change=False)
    clock.create_jump_callback(threshold, post_callback=lambda _: seen.append('jump'))
    clock._set_ros_time_is_active(True)
    assert seen == []
    clock.set_ros_time_override(ros(5))
    assert seen == ['jump']


@pytest.mark.parametrize('kind', [ROS, SYSTEM, STEADY_TIME])
def test_sleep_for_and_until(context: SmallContext, kind: ClockType) -> None:
    clock = Clock(clock_type=kind)
    begun = STEADY.now()
    assert clock.sleep_for(Duration(nanoseconds=20_000_000), context)
    assert STEADY.now() - begun >= 19_000_000
    assert clock.sleep_until(clock.now(), context)


def test_a_sleep_ends_with_the_context(context: SmallContext) -> None:
    def end_it() -> None:
        wait_for(lambda: context.shutdown_signal._watchers, 'the sleep to begin')
        context.shutdown()

    thread = threading.Thread(target=end_it)
    thread.start()
    assert not Clock().sleep_for(Duration(seconds=3600), context)
    thread.join()
    with pytest.raises(NotInitializedException, match='has not been called'):
        Clock().sleep_for(Duration(seconds=1), context)


def test_a_sleep_takes_only_this_clocks_time(context: SmallContext) -> None:
    with pytest.raises(ValueError, match="until's clock type does not match this clock's type"):
        Clock(clock_type=STEADY_TIME).sleep_until(Time(seconds=1), context)
    with pytest.raises(TypeError, match="'Time' and 'int'"):
        Clock(clock_type=STEADY_TIME).sleep_for(1, context)  # type: ignore[arg-type]


def _sleep_in_thread(
    clock: ROSClock, until: Time, context: SmallContext
) -> tuple[threading.Event, list[bool]]:
    """Sleep in a thread of its own; returns once it sleeps."""
    ended, result, others = threading.Event(), list[bool](), len(clock._sleepers)

    def sleep() -> None:
        result.append(clock.sleep_until(until, context))
        ended.set()

    threading.Thread(target=sleep).start()
    wait_for(lambda: len(clock._sleepers) > others, 'the sleep to begin')
    return ended, result


def test_a_sleep_on_sim_time_ends_when_that_time_is_set(context: SmallContext) -> None:
    clock = active()
    ended, result = _sleep_in_thread(clock, ros(2), context)
    earlier, _ = _sleep_in_thread(clock, ros(1), context)
    clock.set_ros_time_override(ros(1))
    assert soon(earlier)
    assert not ended.is_set()
    clock.set_ros_time_override(ros(2.5))
    assert soon(ended)
    assert result == [True]


def test_a_sleep_is_given_up_when_the_source_of_time_is_switched(context: SmallContext) -> None:
    clock = active()
    ended, result = _sleep_in_thread(clock, ros(2), context)
    clock._set_ros_time_is_active(False)
    assert soon(ended)
    assert result == [False]


def test_a_sleep_outlasts_a_jump_back(context: SmallContext) -> None:
    clock = active(10)
    ended, result = _sleep_in_thread(clock, ros(12), context)
    clock.set_ros_time_override(ros(5))
    earlier, _ = _sleep_in_thread(clock, ros(11), context)
    clock.set_ros_time_override(ros(11))
    assert soon(earlier)
    assert not ended.is_set()
    clock.set_ros_time_override(ros(12))
    assert soon(ended)
    assert result == [True]


def test_time_advances_quietly_unless_somebody_is_to_be_told() -> None:
    clock = active(1)
    jumps: list[int] = []
    threshold = JumpThreshold(min_forward=None, min_backward=Duration(seconds=-1))
    handle = clock.create_jump_callback(
        threshold, post_callback=lambda jump: jumps.append(jump.delta.nanoseconds)
    )
    assert clock.advance_quietly(5 * 10**9)
    assert not clock.advance_quietly(3 * 10**9)
    assert clock.now() == ros(5), 'refused: nothing is done'
    handle.unregister()
    assert clock.advance_quietly(3 * 10**9)
    assert clock.now() == ros(3)
    assert jumps == []


def test_a_failing_jump_callback_does_not_keep_the_time_from_others(context: SmallContext) -> None:
    clock = active(1)

    def fails(_: TimeJump) -> None:
        raise ValueError('boom')

    threshold = JumpThreshold(min_forward=Duration(seconds=1), min_backward=None)
    clock.create_jump_callback(threshold, post_callback=fails)
    ended, result = _sleep_in_thread(clock, ros(2), context)
    with pytest.raises(ValueError, match='boom'):
        clock.set_ros_time_override(ros(3))
    assert soon(ended)
    assert result == [True]
    with pytest.raises(ValueError, match='boom'):
        clock._set_ros_time_is_active(False)
    assert not clock.ros_time_is_active


def test_the_steady_time_of_a_clocks_time() -> None:
    assert Clock(clock_type=STEADY_TIME).steady_time_of(5) == 5
    system = Clock()
    ahead = system.steady_time_of(system.now_ns() + 10**9) - STEADY.now()
    assert 0.9e9 < ahead <= 1.01e9


MS = 1_000_000


class Called:
    """Counts the calls of its entry."""

    def __init__(self, clock: Clock, node: SmallNode) -> None:
        self.count = 0
        self.event = threading.Event()
        self.entry = ClockTimerEntry(node.work_queue, clock, self.call)
        self.entry.follow()

    def call(self) -> None:
        self.count += 1
        self.event.set()


@pytest.fixture
def spinning(context: SmallContext) -> Iterator[SmallNode]:
    node = SmallNode()
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    with Spinning(executor):
        yield node


@pytest.mark.parametrize('kind', [ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME])
def test_an_entry_is_called_when_its_clock_shows_the_time(spinning: SmallNode, kind: ClockType) -> None:
    clock = Clock(clock_type=kind)
    called = Called(clock, spinning)
    due = clock.now_ns() + 20 * MS
    called.entry.set(due)
    assert soon(called.event)
    assert clock.now_ns() >= due - MS
    assert called.entry.remaining_ns() is None


def test_on_a_set_clock_it_rings_once_where_the_time_is_set() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    called = Called(clock, SmallNode())
    called.entry.set(2 * 10**9)
    assert called.entry.remaining_ns() == 2 * 10**9
    clock.set_ros_time_override(ros(1.9))
    assert called.count == 0
    for _ in range(3):
        clock.set_ros_time_override(ros(2))
    assert called.count == 1
    called.entry.set(10**9)
    assert called.count == 2, 'a time that is past is called at once'


def test_a_discarded_entry_is_not_called() -> None:
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    called = Called(clock, SmallNode())
    called.entry.set(10**9)
    called.entry.cancel()
    clock.set_ros_time_override(ros(5))
    assert called.count == 0


def test_an_entry_keeps_its_due_time_when_the_source_is_switched(spinning: SmallNode) -> None:
    clock = ROSClock()
    called = Called(clock, spinning)
    called.entry.set(clock.now_ns() + 3600 * 10**9)
    clock._set_ros_time_is_active(True)
    assert called.count == 0
    called.entry.set(10**9)
    clock._set_ros_time_is_active(False)
    assert soon(called.event), 'system time is past the first second of simulated time'
