"""Instants and durations in whole nanoseconds, with the behaviour of rclpy's Time and Duration.

A Time belongs to a kind of clock and is never negative. A Duration may be negative. The nanoseconds of both
must fit an int64, as in rcl; a larger value raises an error. Both classes are immutable, but not hashable, as
in ROS 2.
"""

from __future__ import annotations

from enum import IntEnum
from functools import total_ordering
from math import inf, isfinite
from typing import TYPE_CHECKING, Protocol, Self, overload

if TYPE_CHECKING:
    from builtin_interfaces.msg import Duration as DurationMessage
    from builtin_interfaces.msg import Time as TimeMessage

S_TO_NS = 1_000_000_000
_INT64_MIN, _INT64_MAX = -(2**63), 2**63 - 1

LATEST_STAMP = 2**31 * S_TO_NS - 1
"""The last instant that fits into a builtin_interfaces/Time, in ns: its seconds are an int32, up to January
2038. The library's own stamps do not go beyond this instant, so that programs still run after that date."""


class ClockType(IntEnum):
    """The kind of clock from which an instant was read (rcl_clock_type_t)."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3


class DurationType(Protocol):
    """Any object that has a span of time in an attribute `nanoseconds`."""

    @property
    def nanoseconds(self) -> int: ...


def _total(seconds: float | str, nanoseconds: float) -> int:
    """Return the sum of seconds and nanoseconds in whole nanoseconds.

    Each part's fraction of a nanosecond is cut off.
    """
    # Without this check Python would repeat a string a billion times before it raises an error.
    if isinstance(seconds, str):
        raise ValueError(f'seconds must be a number, got {seconds!r}')  # noqa: TRY004 - rclpy's own type
    return int(seconds * S_TO_NS) + int(nanoseconds)


@total_ordering
class Duration:
    """A span of time; negative ones are allowed."""

    __slots__ = ('__dict__', '__weakref__', '_nanoseconds')  # programs set attributes of their own

    def __init__(self, *, seconds: float = 0, nanoseconds: float = 0) -> None:
        """Make a span of `seconds` plus `nanoseconds`.

        Raises OverflowError beyond an int64, ValueError for NaN.
        """
        total = _total(seconds, nanoseconds)
        if not _INT64_MIN <= total <= _INT64_MAX:
            raise OverflowError('Total nanoseconds value is too large to store in C duration.')
        self._nanoseconds = total

    @property
    def nanoseconds(self) -> int:
        """The whole span in nanoseconds."""
        return self._nanoseconds

    def __repr__(self) -> str:
        return f'Duration(nanoseconds={self._nanoseconds})'

    def __str__(self) -> str:
        return 'Infinite' if self._nanoseconds == _INT64_MAX else f'{self._nanoseconds} nanoseconds'

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Duration):
            return self._nanoseconds == other._nanoseconds
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __lt__(self, other: Duration) -> bool:
        if isinstance(other, Duration):
            return self._nanoseconds < other._nanoseconds
        return NotImplemented

    def __add__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self._nanoseconds + other._nanoseconds)

    def __sub__(self, other: Duration) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)

    def __mul__(self, factor: float) -> Duration:
        """Return the span times a number.

        Infinity gives Infinite; nan raises ValueError, an overflow raises OverflowError.
        """
        if isinstance(factor, int):
            return Duration(nanoseconds=self._nanoseconds * factor)
        if not isinstance(factor, float):
            return NotImplemented
        if factor == inf:
            return Infinite
        if not isfinite(factor):
            raise ValueError(f"Can't multiply duration with {factor}")
        return Duration(nanoseconds=int(self._nanoseconds * factor))

    def to_msg(self) -> DurationMessage:
        """Return the span as a builtin_interfaces/Duration.

        `sec` is rounded down, so `nanosec` is never negative.
        """
        from builtin_interfaces.msg import Duration as DurationMessage

        message = DurationMessage()
        message.sec, message.nanosec = divmod(self._nanoseconds, S_TO_NS)
        return message

    @classmethod
    def from_msg(cls, msg: DurationMessage) -> Self:
        """Return the Duration in a builtin_interfaces/Duration; raises TypeError for anything else."""
        from builtin_interfaces.msg import Duration as DurationMessage

        if not isinstance(msg, DurationMessage):
            raise TypeError('Must pass a builtin_interfaces.msg.Duration object')
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)

    def get_c_duration(self) -> DurationType:
        """Return the object itself, in place of the duration that rclpy's C layer would take."""
        return self


Infinite = Duration(nanoseconds=_INT64_MAX)
"""A duration without end (RMW_DURATION_INFINITE)."""


@total_ordering
class Time:
    """An instant on one kind of clock. Comparing instants of different clocks raises TypeError."""

    __slots__ = ('__dict__', '__weakref__', '_clock_type', '_nanoseconds')

    def __init__(
        self, *, seconds: float = 0, nanoseconds: float = 0, clock_type: ClockType = ClockType.SYSTEM_TIME
    ) -> None:
        """Make the instant `seconds` plus `nanoseconds`.

        Raises ValueError for a negative part, OverflowError beyond an int64.
        """
        if not isinstance(clock_type, ClockType):
            raise TypeError('Clock type must be a ClockType enum')
        if seconds < 0:
            raise ValueError('Seconds value must not be negative')
        if nanoseconds < 0:
            raise ValueError('Nanoseconds value must not be negative')
        total = _total(seconds, nanoseconds)
        if total > _INT64_MAX:
            raise OverflowError('Total nanoseconds value is too large to store in C time point.')
        self._nanoseconds = total
        self._clock_type = clock_type

    @property
    def nanoseconds(self) -> int:
        """Nanoseconds since the clock's own zero."""
        return self._nanoseconds

    @property
    def clock_type(self) -> ClockType:
        """The kind of clock to which this instant belongs."""
        return self._clock_type

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return the time as whole seconds and the remaining nanoseconds."""
        return divmod(self._nanoseconds, S_TO_NS)

    def __repr__(self) -> str:
        return f'Time(nanoseconds={self._nanoseconds}, clock_type={self._clock_type.name})'

    def __add__(self, other: Duration) -> Time:
        if not isinstance(other, Duration):
            return NotImplemented
        try:
            return Time(nanoseconds=self._nanoseconds + other.nanoseconds, clock_type=self._clock_type)
        except OverflowError:
            raise OverflowError('Addition leads to overflow in C storage.') from None

    __radd__ = __add__

    @overload
    def __sub__(self, other: Time) -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> Time: ...
    def __sub__(self, other: Time | Duration) -> Time | Duration:
        if isinstance(other, Time):
            self._refuse_other_clock(other, 'subtract')
            return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)
        if not isinstance(other, Duration):
            return NotImplemented
        try:
            return Time(nanoseconds=self._nanoseconds - other.nanoseconds, clock_type=self._clock_type)
        except ValueError:
            raise ValueError('Subtraction leads to negative time.') from None

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._refuse_other_clock(other, 'compare')
        return self._nanoseconds == other._nanoseconds

    __hash__ = None  # type: ignore[assignment]

    def __lt__(self, other: Time) -> bool:
        if not isinstance(other, Time):
            return NotImplemented
        self._refuse_other_clock(other, 'compare')
        return self._nanoseconds < other._nanoseconds

    def _refuse_other_clock(self, other: Time, verb: str) -> None:
        if self._clock_type is not other._clock_type:
            error = TypeError(f"Can't {verb} times with different clock types")
            error.add_note(
                f'these are {self._clock_type.name} and {other._clock_type.name}: take both from one clock'
            )
            raise error

    def to_msg(self) -> TimeMessage:
        """Return the instant as a builtin_interfaces/Time, which does not carry the kind of clock."""
        from builtin_interfaces.msg import Time as TimeMessage

        message = TimeMessage()
        message.sec, message.nanosec = self.seconds_nanoseconds()
        return message

    def to_stamp(self) -> TimeMessage:
        """Return the instant as a builtin_interfaces/Time for the wire.

        An instant after 2038 becomes LATEST_STAMP.
        """
        return Time(nanoseconds=min(self.nanoseconds, LATEST_STAMP)).to_msg()

    @classmethod
    def from_msg(cls, msg: TimeMessage, clock_type: ClockType = ClockType.ROS_TIME) -> Self:
        """Return the Time in a builtin_interfaces/Time message; raises TypeError for anything else."""
        from builtin_interfaces.msg import Time as TimeMessage

        if not isinstance(msg, TimeMessage):
            raise TypeError('Must pass a builtin_interfaces.msg.Time object')
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec, clock_type=clock_type)
