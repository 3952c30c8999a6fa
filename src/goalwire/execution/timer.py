"""Timer: a callback at a steady rhythm; Rate: sleeping at one (rclpy.timer)."""

from __future__ import annotations

from functools import partial
from threading import Lock
from typing import TYPE_CHECKING, Self
from weakref import ReferenceType, ref

from goalwire.errors import InvalidHandle, ROSInterruptException
from goalwire.execution.callbacks import function_of, signature_of
from goalwire.execution.clock import ClockChange, ClockTimerEntry, ROSClock
from goalwire.execution.handle import entity_of, handle_of
from goalwire.execution.ready_queue import CallbackSource, NodeWorkQueue
from goalwire.execution.waiting import wake_all
from goalwire.rules.latencies import Latencies
from goalwire.rules.time import S_TO_NS, ClockType, Time

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

    from goalwire.execution.callback_groups import CallbackGroup
    from goalwire.execution.clock import Clock
    from goalwire.execution.waiting import ContextLike, Waiter
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
        """Both times in ns. Raises TypeError for anything but a ClockType, ValueError for a negative time."""
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
    """Return how to call `callback` with a TimerInfo; None if it asks for none.

    It asks with a parameter that is annotated as TimerInfo, as in rclpy, or with one that has no default.
    """
    if not callable(callback) or _takes_nothing(callback):
        return None
    from inspect import Parameter  # 5 ms, for few callbacks

    try:
        parameters = signature_of(callback).parameters.values()
    except (TypeError, ValueError):  # a builtin that does not tell
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
    """The quick look at the usual case."""
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
    """Sleeps until its timer is due. Unlike rclpy's it needs no executor that spins meanwhile.

    One that does has a turn with each tick, whether somebody sleeps or not.
    """

    def __init__(self, timer: Timer, *, context: ContextLike) -> None:
        timer.take_over()
        self._timer = timer
        self._context = context
        self._destroyed = False
        self._ticks = 0
        self._sleepers: list[Waiter] = []

    def destroy(self) -> None:
        """End it, and every sleep in it. Idempotent."""
        self._destroyed = True
        self._timer.destroy()
        wake_all(self._sleepers)

    def sleep(self) -> None:
        """Block until the next tick; return at once if one has passed since the last sleep.

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
        """Sleep to the next tick and count it, unless another sleeper has done that, or the clock jumped."""
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
    """Calls `callback` every `timer_period_ns` on `clock`.

    Periods that were missed are made up for by one call, and the phase is kept, as in rcl. It is
    an entry in its node's executor; on an overridden ROS clock the setter of the time posts it. That may be
    another thread than the one that calls: `_lock` keeps the two times together, over no foreign code.
    Where the machine's clock is set back to before the last call, the running period ends in its time all the
    same: `_steady_due` says when.
    """

    __slots__ = (
        '__dict__',  # programs keep things of their own there
        '_callback',
        '_canceled',
        '_clock',
        '_destroyed',
        '_last_call',
        '_lateness',
        '_lock',
        '_missed',
        '_next_call',
        '_period',
        '_posted',
        '_steady_due',
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
        """Raises TypeError for a period beyond an int64. Without `work_queue` no executor ever calls it.

        `callback()` is called, or `callback(info)` if it asks for a TimerInfo.
        """
        super().__init__(NodeWorkQueue() if work_queue is None else work_queue, callback_group)
        if int(timer_period_ns) not in _INT64:
            raise TypeError(
                f'a timer period of {timer_period_ns} ns does not fit into 64 bits: make it shorter'
            )
        self.callback = callback
        self._clock: Clock = entity_of(clock.handle)  # all but clocks are refused here, with rclpy's words
        self._period = int(timer_period_ns)
        self._lock = Lock()
        self._missed = 0
        self._lateness = Latencies()
        self.watchers: Sequence[Callable[[], None]] = ()
        self._last_call = clock.now_ns()
        self._next_call = self._last_call + self._period
        self._steady_due = self._clock.source.now() + self._period
        self._canceled = not autostart
        self._destroyed = self._posted = self._taken = False
        self._timer_entry = ClockTimerEntry(self.work_queue, clock, partial(Timer._post, ref(self)))
        if isinstance(clock, ROSClock):
            clock.watch_jumps(self)
        self._schedule()

    # -- what rclpy offers

    @property
    def callback(self) -> Callable[..., object] | None:
        """The callback; another one may be set at any time."""
        return self._callback

    @callback.setter
    def callback(self, value: Callable[..., object] | None) -> None:
        self._callback = value
        self._with_info = adapt_to_info(value)

    @property
    def callback_group(self) -> CallbackGroup | None:
        """The group that it was made with."""
        return self.group

    @property
    def handle(self) -> Timer:
        """Its handle, as rclpy's programs use it. Raises InvalidHandle once destroyed."""
        self._check()
        return handle_of(self)

    @property
    def clock(self) -> Clock:
        """The clock it goes by."""
        return self._clock

    @property
    def timer_period_ns(self) -> int:
        """The period in ns. A new one counts from the next call on."""
        self._check()
        return self._period

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        value = int(value)
        self._check()
        self._period = value

    def is_ready(self) -> bool:
        """Whether a call is due."""
        self._check()
        return not self._canceled and self._now() >= self._next_call

    def is_canceled(self) -> bool:
        """Whether it is off."""
        self._check()
        return self._canceled

    def cancel(self) -> None:
        """Switch it off, until `reset`."""
        self._check()
        self._canceled = True
        self._timer_entry.cancel()

    def reset(self) -> None:
        """Start anew: the next call is one period from now."""
        self._check()
        with self._lock:
            self._next_call = self._clock.now_ns() + self._period
            self._steady_due = self._clock.source.now() + self._period
            self._canceled = False
        self._schedule()

    def time_since_last_call(self) -> int:
        """Ns since the last call, or since it was made."""
        self._check()
        return self._now() - self._last_call

    def time_until_next_call(self) -> int | None:
        """Return the ns until the next call, negative if it is late; None while canceled."""
        self._check()
        if self._canceled:
            return None
        now = self._now()
        return self._next_call - now

    def destroy(self) -> None:
        """End it. Idempotent."""
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

    # -- what the library builds on

    @property
    def next_call_ns(self) -> int:
        """When the next call is due, on its clock."""
        self._now()
        return self._next_call

    @property
    def events(self) -> int:
        """1 when a call is due, else 0; see waitable.Waited."""
        return int(self.is_ready())

    def call_timer(self) -> None:
        """Note a call that a waitable has made. Raises InvalidHandle once destroyed."""
        self._check()
        self.advance()
        self._schedule()

    def take_over(self) -> None:
        """Leave calling to somebody else, a Rate: no executor calls it from now on.

        It has a turn of its executor with each period all the same, as in rclpy: a program may go round a
        loop with `spin_once` until something has changed that another thread does at this rhythm.
        """
        self._taken = True
        self._schedule()

    def advance(self) -> tuple[int, int] | None:
        """Note a call and find the next due time, in phase and in the future; None if none is due yet.

        Returns when the call was due and when it came.
        """
        with self._lock:
            now, due = self._clock.now_ns(), self._next_call
            if now < due:
                due = self._due_after_set_back(now)
                if now < due:
                    return None
            period = max(self._period, 0)
            following = due + period
            if following <= now:
                self._missed += (now - following) // period + 1 if period else 0
                following = now if period == 0 else now + period - (now - following) % period
            self._last_call, self._next_call = now, following
            self._steady_due = self._clock.source.now() + following - now
        self._lateness.counts[(now - due).bit_length()] += 1
        return due, now

    def _now(self) -> int:
        """Return the clock's time. If the clock was set back, the next call is fitted to it."""
        now = self._clock.now_ns()
        if now < self._last_call:
            with self._lock:
                self._due_after_set_back(now)
        return now

    def _due_after_set_back(self, now: int) -> int:
        """When the next call is due, now that the clock shows `now`.

        A jump to before the last call would stop the timer until the old time is there again. Who sets a
        clock by hand says so (`clock_jumped`); nobody tells of the machine's.
        """
        if now < self._last_call and not self._clock.overridden:
            self._next_call = now + max(self._steady_due - self._clock.source.now(), 0)
            self._last_call = min(self._next_call - self._period, now)
        return self._next_call

    def statistics(self) -> TimerStatistics:
        """Count its calls, and how late they came."""
        from goalwire.rules.statistics import TimerStatistics

        lateness = self._lateness.histogram()
        return TimerStatistics(self._period / S_TO_NS, lateness.count, self._missed, lateness)

    def run(self) -> object:
        self._posted = False
        if self._canceled:
            return None
        if self._taken:
            self._schedule()
            return None
        times = self.advance()
        self._schedule()  # before the callback: in a reentrant group it may overlap itself
        if times is None:
            return None
        if self._with_info is not None:
            return self._with_info(self._info(*times))
        return self._callback()  # type: ignore[misc]  # None is called as in rclpy: TypeError

    def _info(self, expected: int, actual: int) -> TimerInfo:
        kind = self._clock.clock_type
        return TimerInfo(expected_call_time=expected, actual_call_time=actual, clock_type=kind)

    def remaining_ns(self) -> int | None:
        """The rest of the running period in ns, before its clock's source of time is switched."""
        return None if self._canceled else self._next_call - self._clock.now_ns()

    def clock_jumped(self, change: ClockChange, remaining_ns: int | None) -> None:
        """Adapt to the clock's new time.

        Where the source was switched, the rest of the period is still to be waited for; a jump to before the
        last call starts a new period (rcl/timer.c's rules).
        """
        with self._lock:
            now = self._clock.now_ns()
            if change is not ClockChange.ROS_TIME_NO_CHANGE:
                if now != 0 and remaining_ns is not None:
                    self._next_call = now + max(remaining_ns, 0)
                    self._last_call = self._next_call - self._period
            elif now < self._last_call:
                self._next_call = now + self._period
                self._last_call = now
            self._steady_due = self._clock.source.now() + self._next_call - now
        self._schedule()

    def _schedule(self) -> None:
        if not self._canceled:
            self._timer_entry.set(self._next_turn() if self._taken else self._next_call)
            if self._destroyed:  # by another thread, which found nothing to cancel
                self._timer_entry.cancel()
        for wake in self.watchers:
            wake()

    def _next_turn(self) -> int:
        """Return the time of the next call. The present one may be late, so whole periods are skipped."""
        due = self.next_call_ns
        late = self._clock.now_ns() - due
        return due if late < 0 else due + (late // max(self._period, 1) + 1) * max(self._period, 1)

    @staticmethod
    def _post(reference: ReferenceType[Timer]) -> None:
        # hot path: an executor that the node has left does not hold the timer, and yet this is one call.
        self = reference()
        if self is not None and not self._posted:
            self._posted = True
            self.work_queue.post(self)

    def _check(self) -> None:
        if self._destroyed:
            raise InvalidHandle
