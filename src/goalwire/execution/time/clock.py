"""Clocks: system, steady and ROS time (rclpy.clock), their jumps, and timer entries that follow a clock."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any, Protocol, Self, TypedDict

from goalwire.errors import LocalError, NotInitializedException
from goalwire.execution.current_callback import add_capacity
from goalwire.execution.rclpy_handle import handle_of
from goalwire.execution.shutdown_signal import ContextLike, default_context
from goalwire.execution.time.steady_clock import STEADY, SteadyClock
from goalwire.execution.time.timer_heap import TimerEntry
from goalwire.execution.waiters import wake_all
from goalwire.rules.time import ClockType, Duration, Time
from goalwire.weak_members import WeakMembers

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from goalwire.execution.future import Future
    from goalwire.execution.ready_queue import NodeWorkQueue
    from goalwire.execution.shutdown_signal import ShutdownSignal
    from goalwire.execution.waiters import Waiter


class ClockChange(IntEnum):
    """How the source of a clock changed (rcl_clock_change_t)."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class TimeJumpDictionary(TypedDict):
    """A jump in the form in which rclpy's C layer passes it to callbacks."""

    clock_change: str
    delta: int


class JumpThreshold:
    """The least jumps for which callbacks are called: `min_forward` and `min_backward`."""

    def __init__(
        self, *, min_forward: Duration | None, min_backward: Duration | None, on_clock_change: bool = True
    ) -> None:
        """Raises ValueError for a threshold of the wrong sign, and if all three conditions are off."""
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError('min_forward must be a positive non-zero duration')
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError('min_backward must be a negative non-zero duration')
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError('At least one jump threshold must be enabled')
        self.min_forward = min_forward
        self.min_backward = min_backward
        self.on_clock_change = on_clock_change

    def is_met_by(self, jump: TimeJump) -> bool:
        """Tell whether `jump` is large enough."""
        if jump.clock_change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_clock_change
        forward, backward = self.min_forward, self.min_backward
        delta = jump.delta.nanoseconds
        return (forward is not None and delta >= forward.nanoseconds) or (
            backward is not None and delta <= backward.nanoseconds
        )


class TimeJump:
    """One jump: what changed, and by how much."""

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError('clock_change must be a ClockChange')
        self._clock_change = clock_change
        self._delta = delta

    @property
    def clock_change(self) -> ClockChange:
        """The kind of change."""
        return self._clock_change

    @property
    def delta(self) -> Duration:
        """New time minus old time."""
        return self._delta


class JumpHandle:
    """A registered pair of jump callbacks."""

    def __init__(
        self,
        *,
        clock: Clock,
        threshold: JumpThreshold,
        pre_callback: Callable[[], object] | None,
        post_callback: Callable[[TimeJump], object] | None,
    ) -> None:
        """Raises ValueError if no callback is given, or if one of them is not callable."""
        if pre_callback is None and post_callback is None:
            raise ValueError('One of pre_callback or post_callback must be callable')
        if pre_callback is not None and not callable(pre_callback):
            raise ValueError('pre_callback must be callable if given')
        if post_callback is not None and not callable(post_callback):
            raise ValueError('post_callback must be callable if given')
        self.threshold = threshold
        self.pre_callback = pre_callback
        self.post_callback = post_callback
        self._clock: Clock | None = clock
        clock.jump_handles.append(self)

    def unregister(self) -> None:
        """Stop calling the callbacks. Idempotent."""
        clock, self._clock = self._clock, None
        if clock is not None:
            clock.jump_handles.remove(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, t: type[BaseException] | None, v: BaseException | None, tb: TracebackType | None
    ) -> None:
        self.unregister()


class JumpListener(Protocol):
    """A timer, or the entry of a timer, that follows every change of its clock's time.

    The thread that changes the time calls these methods.
    """

    def clock_jumped(self, change: ClockChange, remaining_ns: int | None) -> None:
        """Adapt to the new time. At a switch of the clock's source, `remaining_ns` is the time that was left
        until the next call.
        """

    def remaining_ns(self) -> int | None:
        """Return the time until the next call, in ns."""


class Clock:
    """A source of `Time`. `Clock(clock_type=ClockType.ROS_TIME)` is a ROSClock, as in rclpy."""

    def __new__(  # noqa: PYI034
        cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME, source: SteadyClock = STEADY  # noqa: ARG004
    ) -> Clock:  # fmt: skip
        """Make a clock; raises TypeError if `clock_type` is not a ClockType."""
        if not isinstance(clock_type, ClockType):
            raise TypeError('Clock type must be a ClockType enum')
        return super().__new__(ROSClock if clock_type is ClockType.ROS_TIME or cls is ROSClock else cls)

    def __init__(
        self, *, clock_type: ClockType = ClockType.SYSTEM_TIME, source: SteadyClock = STEADY
    ) -> None:
        self._clock_type = clock_type
        self.source = source
        """The machine's time, or the virtual time that stands in for it."""
        self.overridden = False
        """True while a program or the /clock topic sets its time: the machine's time then does not move it.
        """
        self.jump_handles: list[JumpHandle] = []
        """The callbacks before and after each jump."""

    @property
    def clock_type(self) -> ClockType:
        """The kind of time that the clock shows."""
        return self._clock_type

    @property
    def handle(self) -> Clock:
        """The clock's handle, as programs of rclpy use it."""
        return handle_of(self)

    def __repr__(self) -> str:
        return f'Clock(clock_type={self._clock_type.name})'

    def now(self) -> Time:
        """The clock's time now."""
        return Time(nanoseconds=self.now_ns(), clock_type=self._clock_type)

    def now_ns(self) -> int:
        """The clock's time now, in ns."""
        if self._clock_type is ClockType.STEADY_TIME:
            return self.source.now()
        if self._clock_type is ClockType.UNINITIALIZED:
            raise LocalError('a clock of type UNINITIALIZED tells no time: choose another ClockType')
        return self.source.system_now()

    def steady_time_of(self, time_ns: int) -> int:
        """Return the steady time, in ns, at which this clock will show `time_ns` if it is not overridden."""
        if self._clock_type is ClockType.STEADY_TIME:
            return time_ns
        source = self.source
        return source.now() + time_ns - source.system_now()

    def create_jump_callback(
        self,
        threshold: JumpThreshold,
        *,
        pre_callback: Callable[[], object] | None = None,
        post_callback: Callable[[TimeJump], object] | None = None,
    ) -> JumpHandle:
        """Have `pre_callback()` called before, and `post_callback(jump)` after, each jump that meets
        `threshold`.

        Only ROS time jumps. Raises ValueError if no callback is given, or if one of them is not callable.
        """
        return JumpHandle(
            clock=self, threshold=threshold, pre_callback=pre_callback, post_callback=post_callback
        )

    def sleep_until(self, until: Time, context: ContextLike | None = None) -> bool:
        """Block until this clock shows `until` (True), or the context ends or ROS time is switched (False).

        Raises NotInitializedException if the context is not up, ValueError for a time of another clock type.
        """
        return self._sleep(until, context)

    def _sleep(self, until: Time, context: ContextLike | None, steady_end: int | None = None) -> bool:
        """Sleep as `sleep_until` does, and until the steady time `steady_end` at the latest."""
        context = default_context() if context is None else context
        if not context.ok():
            raise NotInitializedException
        if until.clock_type is not self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        shutdown_signal = context.shutdown_signal
        waiter = shutdown_signal.new_waiter()
        return self.wait_until(until.nanoseconds, waiter, shutdown_signal, steady_end=steady_end)

    def sleep_for(self, rel_time: Duration, context: ContextLike | None = None) -> bool:
        """Block for `rel_time` of this clock, also if the machine's clock is set meanwhile; see
        `sleep_until`.
        """
        return self._sleep(self.now() + rel_time, context, self.steady_end_of(rel_time.nanoseconds))

    def steady_end_of(self, duration_ns: int) -> int | None:
        """Return the steady time, in ns, at which `duration_ns` from now have passed.

        Returns None while this clock is overridden, since simulated time goes its own way.
        """
        return None if self.overridden else self.source.now() + duration_ns

    def wait_until(
        self,
        target_ns: int,
        waiter: Waiter,
        shutdown_signal: ShutdownSignal,
        is_over: Callable[[], bool] = bool,
        steady_end: int | None = None,
    ) -> bool:
        """Sleep until this clock shows `target_ns` (True), or until `is_over()` or the shutdown (False).

        The steady time `steady_end` ends the sleep, too (True), unless this clock is overridden: whoever sets
        the machine's clock back makes no sleep longer.
        """
        watch = shutdown_signal.watch(waiter.wake)
        try:
            while shutdown_signal.alive:
                # The clock is read before `is_over()`, which may notice that the clock has been set back.
                missing = target_ns - self.now_ns()
                if steady_end is not None and not self.overridden:
                    missing = min(missing, steady_end - self.source.now())
                if is_over():
                    return False
                if missing <= 0:
                    return True
                self._wait_on_lock(waiter, missing)
            return False
        finally:
            watch.close()

    def _wait_on_lock(self, waiter: Waiter, missing_ns: int) -> None:
        self.source.wait(waiter, self.source.now() + missing_ns)


class ROSClock(Clock):
    """System time, or the overriding time, which comes from the /clock topic under `use_sim_time`."""

    def __init__(self, *, source: SteadyClock = STEADY, clock_type: ClockType = ClockType.ROS_TIME) -> None:
        super().__init__(clock_type=clock_type, source=source)
        self._override_ns = 0
        self._switches = 0
        self._sleepers: list[Waiter] = []
        self.before_sleep: list[Callable[[], bool]] = []
        """Functions that a thread calls before it sleeps on the overridden clock; each returns True if it has
        set the time.
        """
        self._listeners: WeakMembers[JumpListener] = WeakMembers()

    @property
    def ros_time_is_active(self) -> bool:
        """True while the clock shows the overriding ROS time."""
        return self.overridden

    def now_ns(self) -> int:
        return self._override_ns if self.overridden else self.source.system_now()

    def set_ros_time_override(self, time: Time) -> None:
        """Set the time that this clock shows while ROS time is active, and post the timers that become due.

        It calls the jump callbacks on the calling thread. Raises TypeError for anything but a Time.
        """
        if not isinstance(time, Time):
            raise TypeError(f'Time must be specified as rclpy.time.Time. Received type: {type(time)}')
        new = time.nanoseconds
        if not self.overridden:
            self._override_ns = new
            return
        jump = TimeJump(ClockChange.ROS_TIME_NO_CHANGE, Duration(nanoseconds=new - self._override_ns))
        told = self._tell_before(jump)
        self._override_ns = new
        try:
            self._tell_after(jump, told)
        finally:
            self._spread(jump.clock_change)

    def advance_quietly(self, time_ns: int) -> bool:
        """Set the time like `set_ros_time_override`; if that would call a jump callback, only
        return False.
        """
        if self.overridden:
            if self.jump_handles:
                delta = Duration(nanoseconds=time_ns - self._override_ns)
                if self._concerns(TimeJump(ClockChange.ROS_TIME_NO_CHANGE, delta)):
                    return False
            self._override_ns = time_ns
            self._spread(ClockChange.ROS_TIME_NO_CHANGE)
        else:
            self._override_ns = time_ns
        return True

    def watch_jumps(self, listener: JumpListener) -> None:
        """Call `clock_jumped` of `listener`, which is held weakly, at every change of the time."""
        self._listeners.add(listener)

    def wait_until(
        self,
        target_ns: int,
        waiter: Waiter,
        shutdown_signal: ShutdownSignal,
        is_over: Callable[[], bool] = bool,
        steady_end: int | None = None,
    ) -> bool:
        # A switch between system and overriding time ends the wait: the target belongs to the time before it.
        switches = self._switches
        self._sleepers.append(waiter)
        try:
            return super().wait_until(
                target_ns,
                waiter,
                shutdown_signal,
                lambda: is_over() or self._switches != switches,
                steady_end,
            )
        finally:
            self._sleepers.remove(waiter)

    def switch_override(self, enabled: bool) -> None:
        """Switch between the override and system time."""
        if enabled == self.overridden:
            return
        # The order is that of rcl: pre-callbacks, the switch, post-callbacks. The listeners' remaining times
        # are read before the switch, since they are in the time of the earlier source.
        change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        jump = TimeJump(change, Duration())
        told = self._tell_before(jump)
        listeners = [(listener, listener.remaining_ns()) for listener in self._listeners.alive()]
        self.overridden = enabled
        self._switches += 1
        try:
            self._tell_after(jump, told)
        finally:
            for listener, remaining in listeners:
                listener.clock_jumped(change, remaining)
            self.wake_sleepers()

    _set_ros_time_is_active = switch_override
    """The name of `switch_override` in rclpy."""

    def _concerns(self, jump: TimeJump) -> list[JumpHandle]:
        return [handle for handle in tuple(self.jump_handles) if handle.threshold.is_met_by(jump)]

    def _tell_before(self, jump: TimeJump) -> list[JumpHandle]:
        told = self._concerns(jump)
        for handle in told:
            if handle.pre_callback is not None:
                handle.pre_callback()
        return told

    @staticmethod
    def _tell_after(jump: TimeJump, told: list[JumpHandle]) -> None:
        for handle in told:
            if handle.post_callback is not None:
                handle.post_callback(jump)

    def _spread(self, change: ClockChange) -> None:
        """Tell all timers and sleepers of this clock that its time has changed."""
        for listener in self._listeners.alive():
            listener.clock_jumped(change, None)
        self.wake_sleepers()

    def wake_sleepers(self) -> None:
        """Wake all sleepers of this clock, so that they look at its time again."""
        wake_all(self._sleepers)

    def _wait_on_lock(self, waiter: Waiter, missing_ns: int) -> None:
        if not self.overridden:
            super()._wait_on_lock(waiter, missing_ns)
        elif not any(help_on() for help_on in self.before_sleep):
            with add_capacity():  # the executor may have to run the callback that sets the time
                self.source.wait(waiter, None)


class ClockTimerEntry(TimerEntry):
    """A function that is called once, when `clock` shows the due time.

    An executor's thread calls it, or the thread that sets the time. `call` must be short and call no user
    code. `due` is None while no call is set. While the clock is overridden, `due` is in ns of the clock, and
    the entry is in no timer heap.
    """

    __slots__ = ('_clock', '_time', '_work_queue')

    def __init__(self, work_queue: NodeWorkQueue, clock: Clock, call: Callable[[], None]) -> None:
        super().__init__(call)
        self._work_queue = work_queue
        self._clock = clock
        self._time = 0

    @property
    def time(self) -> int | None:
        """The time of the call, in ns of the clock; None while no call is set."""
        return None if self.due is None else self._time

    def follow(self) -> None:
        """Register this entry for the clock's jumps. Not to be called if a timer passes the jumps on to the
        entry.
        """
        if isinstance(self._clock, ROSClock):
            self._clock.watch_jumps(self)

    def set(self, time_ns: int, steady_ns: int | None = None) -> None:
        """Have the entry called at `time_ns` instead of any earlier set time; at once if an overridden clock
        shows that time already.

        `steady_ns` is the same time on the steady clock, for a caller that knows it.
        """
        self._time = time_ns
        clock = self._clock
        if not clock.overridden:
            due = clock.steady_time_of(time_ns) if steady_ns is None else steady_ns
            self._work_queue.set_timer_entry(self, due)
            return
        self._work_queue.discard_timer_entry(self)
        if clock.now_ns() >= time_ns:
            self.call()
        else:
            self.due = time_ns

    def cancel(self) -> None:
        """Forget the call."""
        self._work_queue.discard_timer_entry(self)

    def remaining_ns(self) -> int | None:
        """Return the time until the call, in ns; None while no call is set."""
        return None if self.due is None else self._time - self._clock.now_ns()

    def clock_jumped(self, _change: ClockChange, _remaining_ns: int | None) -> None:
        """Adapt to the clock's new time."""
        if self.due is not None:
            self.set(self._time)


def block_on_clock(future: Future[Any], clock: Clock, until_ns: int, shutdown_signal: ShutdownSignal) -> bool:
    """Block until `future` is settled (True); False when `clock` shows `until_ns`, or at the shutdown.

    A switch between system and simulated time ends the wait, too, since `until_ns` belongs to the earlier
    one.
    """
    waiter = shutdown_signal.new_waiter()
    steady_end = clock.steady_end_of(until_ns - clock.now_ns())
    future.add_waker(waiter.wake)
    try:
        with add_capacity():
            clock.wait_until(until_ns, waiter, shutdown_signal, future.settled, steady_end)
        return future.settled()
    finally:
        future.remove_waker(waiter.wake)
