"""Timer calls a callback at a steady rate; Rate lets a thread sleep at a steady rate (rclpy.timer)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Self
from weakref import ReferenceType, ref

from goalwire.errors import InvalidHandle, ROSInterruptException
from goalwire.execution.callback_arguments import function_of, signature_of
from goalwire.execution.rclpy_handle import entity_of, handle_of
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
from goalwire.execution.time.clock import ClockTimerEntry, ROSClock
from goalwire.execution.time.timer_schedule import TimerSchedule
from goalwire.execution.waiters import wake_all
from goalwire.rules.time import ClockType, Time

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.shutdown_signal import ContextLike
    from goalwire.execution.time.clock import Clock, ClockChange
    from goalwire.execution.waiters import Waiter
    from goalwire.rules.statistics import TimerStatistics


class TimerInfo:
    """When a call was due and when it came, both in the time of the timer's clock."""

    __slots__ = ('_actual', '_expected')

    def __init__(
        self,
        *,
        expected_call_time: int = 0,
        actual_call_time: int = 0,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
    ) -> None:
        """Take both times in ns. Raises TypeError if `clock_type` is not a ClockType, ValueError for negative
        times.
        """
        if not isinstance(clock_type, ClockType):
            raise TypeError('Clock type must be a ClockType enum')
        if expected_call_time < 0 or actual_call_time < 0:
            raise ValueError('call time values must not be negative')
        self._expected = Time(nanoseconds=expected_call_time, clock_type=clock_type)
        self._actual = Time(nanoseconds=actual_call_time, clock_type=clock_type)

    @property
    def expected_call_time(self) -> Time:
        """When the call was due."""
        return self._expected

    @property
    def actual_call_time(self) -> Time:
        """When the call came."""
        return self._actual


def adapt_to_info(callback: object) -> Callable[[TimerInfo], object] | None:
    """Return a function that calls `callback` with a TimerInfo; None if `callback` does not take one.

    It takes one if it has a parameter that is annotated as TimerInfo, as in rclpy, or that has no default.
    """
    if not callable(callback) or _takes_nothing(callback):
        return None
    from inspect import Parameter  # imported here: it takes 5 ms, and few callbacks need it

    try:
        parameters = signature_of(callback).parameters.values()
    except (TypeError, ValueError):  # some builtins have no signature
        return None
    for parameter in parameters:
        if _is_timer_info(parameter.annotation):
            name = parameter.name
            if parameter.kind is Parameter.POSITIONAL_ONLY:
                return callback
            return lambda info: callback(**{name: info})
    positional = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    required = [one for one in parameters if one.default is Parameter.empty and one.kind in positional]
    return callback if required else None


def _takes_nothing(callback: object) -> bool:
    """Tell, without inspect, whether `callback` is a plain function that takes no arguments."""
    function, given = function_of(callback)
    if function is None:
        return False
    code = function.__code__
    return code.co_argcount <= given and not code.co_kwonlyargcount


def _is_timer_info(annotation: object) -> bool:
    if isinstance(annotation, str):
        return annotation.strip('\'"').rpartition('.')[2] == 'TimerInfo'
    return annotation is TimerInfo


class Rate:
    """Sleeps until its timer is due. Unlike rclpy's, it works without an executor that spins meanwhile.

    If an executor spins, each tick is one turn of it, whether a thread sleeps here or not.
    """

    def __init__(self, timer: Timer, *, context: ContextLike) -> None:
        timer.take_over()
        self._timer = timer
        self._context = context
        self._destroyed = False
        self._ticks = 0
        self._sleepers: list[Waiter] = []

    def destroy(self) -> None:
        """Destroy the timer and end every sleep. Idempotent."""
        self._destroyed = True
        self._timer.destroy()
        wake_all(self._sleepers)

    def sleep(self) -> None:
        """Block until the next tick; return at once if a tick has passed since the last sleep.

        Raises RuntimeError when destroyed, ROSInterruptException when the context has ended.
        """
        self._check()
        waiter, before = self._context.shutdown_signal.new_waiter(), self._ticks
        self._sleepers.append(waiter)
        try:
            while self._ticks == before:
                self._wait_for_tick(waiter, before)
                self._check()
        finally:
            self._sleepers.remove(waiter)

    def _wait_for_tick(self, waiter: Waiter, before: int) -> None:
        """Sleep until the next tick, and count it unless another sleeper has counted it.

        Returns early if the due time has moved, as after a jump of the clock; the caller then sleeps again.
        """
        timer = self._timer
        target = timer.next_call_ns

        def moved() -> bool:
            return self._destroyed or self._ticks != before or timer.next_call_ns != target

        reached = timer.clock.wait_until(target, waiter, self._context.shutdown_signal, moved)
        if reached and self._ticks == before and timer.advance() is not None:
            self._ticks += 1

    def _check(self) -> None:
        if self._destroyed:
            raise RuntimeError('Rate cannot sleep because it has been destroyed')
        if not self._context.ok():
            raise ROSInterruptException


_INT64 = range(-(2**63), 2**63)


class Timer(CallbackSource):
    """Calls `callback` every `timer_period_ns` of `clock`. TimerSchedule has the due times.

    An entry in the timer heap of the node's executor posts it when it is due. If the ROS clock is overridden,
    the thread that sets the time posts it.
    """

    __slots__ = (
        '__dict__',  # programs may set attributes of their own
        '_callback',
        '_canceled',
        '_clock',
        '_destroyed',
        '_posted',
        '_schedule',
        '_taken',
        '_timer_entry',
        '_with_info',
        'watchers',
    )

    counts_up = False

    def __init__(
        self,
        callback: Callable[..., object] | None,
        callback_group: CallbackGroup | None,
        timer_period_ns: int,
        clock: Clock,
        *,
        context: ContextLike | None = None,  # noqa: ARG002
        autostart: bool = True,
        work_queue: NodeWorkQueue | None = None,
    ) -> None:
        """Make a timer that calls `callback()`, or `callback(info)` if it takes a TimerInfo.

        Without `work_queue` no executor ever calls it. Raises TypeError for a period beyond an int64.
        """
        super().__init__(NodeWorkQueue() if work_queue is None else work_queue, callback_group)
        if int(timer_period_ns) not in _INT64:
            raise TypeError(
                f'a timer period of {timer_period_ns} ns does not fit into 64 bits: make it shorter'
            )
        self.callback = callback
        # This raises an error with rclpy's text if `clock` is not a clock.
        self._clock: Clock = entity_of(clock.handle)
        self._schedule = TimerSchedule(self._clock, int(timer_period_ns))
        self.watchers: Sequence[Callable[[], None]] = ()
        self._canceled = not autostart
        self._destroyed = self._posted = self._taken = False
        self._timer_entry = ClockTimerEntry(self.work_queue, clock, partial(Timer._post, ref(self)))
        if isinstance(clock, ROSClock):
            clock.watch_jumps(self)
        self._arm()

    # -- methods of rclpy's Timer

    @property
    def callback(self) -> Callable[..., object] | None:
        """The callback. It may be replaced at any time."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., object] | None) -> None:
        self._callback = value
        self._with_info = adapt_to_info(value)

    @property
    def callback_group(self) -> CallbackGroup | None:
        """The callback group that was passed to the constructor."""
        return self.group

    @property
    def handle(self) -> Timer:
        """The timer's handle, as programs of rclpy use it. Raises InvalidHandle once destroyed."""
        self._check()
        return handle_of(self)

    @property
    def clock(self) -> Clock:
        """The timer's clock."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """The period in ns. A new period takes effect after the next call."""
        self._check()
        return self._schedule.period

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        value = int(value)
        self._check()
        self._schedule.period = value

    def is_ready(self) -> bool:
        """Tell whether a call is due."""
        self._check()
        return not self._canceled and self._schedule.now() >= self._schedule.next_call

    def is_canceled(self) -> bool:
        """True after `cancel`, until `reset`."""
        self._check()
        return self._canceled

    def cancel(self) -> None:
        """Stop the calls, until `reset`."""
        self._check()
        self._canceled = True
        self._timer_entry.cancel()

    def reset(self) -> None:
        """Begin a new period: the next call is one period from now."""
        self._check()
        self._schedule.restart()
        self._canceled = False
        self._arm()

    def time_since_last_call(self) -> int:
        """Return the ns since the last call; before the first call, since the timer was made."""
        self._check()
        return self._schedule.now() - self._schedule.last_call

    def time_until_next_call(self) -> int | None:
        """Return the ns until the next call, negative if it is late; None while canceled."""
        self._check()
        if self._canceled:
            return None
        now = self._schedule.now()
        return self._schedule.next_call - now

    def destroy(self) -> None:
        """End the timer. Idempotent."""
        self._destroyed = self._canceled = True
        self._timer_entry.cancel()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.destroy()

    # -- methods for goalwire itself

    @property
    def next_call_ns(self) -> int:
        """The due time of the next call, in ns of the timer's clock."""
        self._schedule.now()
        return self._schedule.next_call

    @property
    def events(self) -> int:
        """1 if a call is due, else 0; see waitable.Waited."""
        return int(self.is_ready())

    def call_timer(self) -> None:
        """Note that a waitable handles the present call. Raises InvalidHandle once destroyed."""
        self._check()
        self.advance()
        self._arm()

    def take_over(self) -> None:
        """Leave the calls of this timer to a Rate: executors do not call the callback any longer.

        As in rclpy, the timer still wakes its executor once a period, so that `spin_once` returns. A program
        may repeat `spin_once` until another thread, which sleeps by the Rate, has done its work.
        """
        self._taken = True
        self._arm()

    def advance(self) -> tuple[int, int] | None:
        """Note a call, and return its due time and its actual time; None if no call is due yet."""
        return self._schedule.advance()

    def statistics(self) -> TimerStatistics:
        """Return the number of calls, and how late they came."""
        return self._schedule.statistics()

    def run(self) -> object:
        self._posted = False
        if self._canceled:
            return None
        if self._taken:
            self._arm()
            return None
        schedule = self._schedule
        times = schedule.advance()
        if times is None:
            self._arm()
            return None
        # hot path: the body of `_arm`, without its call and without its two readings of clocks, which
        # `advance` has made. This is done before the callback: in a reentrant group the next call may start
        # during this one.
        self._timer_entry.set(schedule.next_call, schedule.steady_due)
        if self._destroyed:
            self._timer_entry.cancel()
        for wake in self.watchers:
            wake()
        if self._with_info is not None:
            return self._with_info(self._info(*times))
        return self._callback()  # type: ignore[misc]  # None is called as in rclpy: TypeError

    def _info(self, expected: int, actual: int) -> TimerInfo:
        kind = self._clock.clock_type
        return TimerInfo(expected_call_time=expected, actual_call_time=actual, clock_type=kind)

    def remaining_ns(self) -> int | None:
        """Return the rest of the running period in ns. A clock asks before it switches its source of time."""
        return None if self._canceled else self._schedule.next_call - self._clock.now_ns()

    def clock_jumped(self, change: ClockChange, remaining_ns: int | None) -> None:
        """Adapt to the clock's new time."""
        self._schedule.follow_jump(change, remaining_ns)
        self._arm()

    def _arm(self) -> None:
        if not self._canceled:
            schedule = self._schedule
            self._timer_entry.set(schedule.next_turn() if self._taken else schedule.next_call)
            if self._destroyed:  # another thread may have destroyed the timer before the entry was set
                self._timer_entry.cancel()
        for wake in self.watchers:
            wake()

    @staticmethod
    def _post(reference: ReferenceType[Timer]) -> None:
        # hot path: a static method with a weak reference. It is one call, and a timer heap that still has the
        # entry does not keep the timer alive.
        self = reference()
        if self is not None and not self._posted:
            self._posted = True
            self.work_queue.post(self)

    def _check(self) -> None:
        if self._destroyed:
            raise InvalidHandle
