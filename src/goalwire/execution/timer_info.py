"""What a timer can tell its callback: when it was to be called, and when it is (rclpy.timer.TimerInfo)."""

from __future__ import annotations

import sys
from types import FunctionType, MethodType
from typing import TYPE_CHECKING

from goalwire.rules.time import ClockType, Time

if TYPE_CHECKING:
    from collections.abc import Callable
    from inspect import Signature


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
        """Both times in ns. Raises TypeError for what is no ClockType, ValueError for a negative time."""
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


def taking_info(callback: object) -> Callable[[TimerInfo], object] | None:
    """Return how to call `callback` with a TimerInfo; None where it asks for none.

    It asks with a parameter that is annotated as TimerInfo, as in rclpy, or with one that has no default.
    """
    if not callable(callback) or _takes_nothing(callback):
        return None
    from inspect import Parameter  # 5 ms, for few callbacks

    try:
        parameters = _signature(callback).parameters.values()
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


def _takes_nothing(callback: Callable[..., object]) -> bool:
    """The quick look at the usual case."""
    if isinstance(callback, MethodType):
        function, given = callback.__func__, 1
    else:
        function, given = callback, 0
    if not isinstance(function, FunctionType):
        return False
    code = function.__code__
    return code.co_argcount <= given and not code.co_kwonlyargcount


def _signature(callback: Callable[..., object]) -> Signature:
    from inspect import signature

    if sys.version_info >= (3, 14):  # annotations that were imported for type checkers only have no value
        from annotationlib import Format

        return signature(callback, annotation_format=Format.STRING)
    return signature(callback)


def _is_timer_info(annotation: object) -> bool:
    if isinstance(annotation, str):
        return annotation.strip('\'"').rpartition('.')[2] == 'TimerInfo'
    return annotation is TimerInfo
