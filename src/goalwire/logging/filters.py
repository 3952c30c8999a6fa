"""Filters that a log call may ask for: `throttle_duration_sec`, `skip_first`, `once`.

Each filter keeps its state in the context of its call site: a dictionary that also has the options of the
first call.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import ClassVar, Protocol, cast, runtime_checkable

from goalwire.errors import LoggingOptionError

Context = dict[str, object]


class _Instant(Protocol):
    @property
    def nanoseconds(self) -> int: ...


@runtime_checkable
class LogClock(Protocol):
    """An object with a method `now`, such as rclpy.clock.Clock."""

    def now(self) -> _Instant:
        """Return the present time, with the attribute `nanoseconds`."""
        ...


class _SteadyInstant:
    __slots__ = ('nanoseconds',)

    def __init__(self) -> None:
        self.nanoseconds = time.monotonic_ns()


class _SteadyClock:
    def now(self) -> _SteadyInstant:
        return _SteadyInstant()


class LoggingFilter:
    """A filter for log calls: the options that request it, and the decision whether a call passes."""

    params: ClassVar[Mapping[str, object]] = {}
    """The filter's options and their defaults; an option with the default None must be given."""

    @classmethod
    def initialize_context(cls, context: Context, **kwargs: object) -> None:
        """Put the options of a call site's first call into the context of the call site."""
        for name, default in cls.params.items():
            context[name] = kwargs.get(name, default)

    @staticmethod
    def should_log(context: Context) -> bool:
        """Return whether the present call passes, and note the call in the context."""
        raise NotImplementedError


class Once(LoggingFilter):
    """Lets only the first call pass that reaches this filter."""

    params: ClassVar[Mapping[str, object]] = {'once': None}

    @classmethod
    def initialize_context(cls, context: Context, **kwargs: object) -> None:
        super().initialize_context(context, **kwargs)
        context['has_been_logged_once'] = False

    @staticmethod
    def should_log(context: Context) -> bool:
        first = not context['has_been_logged_once']
        context['has_been_logged_once'] = True
        return first


class SkipFirst(LoggingFilter):
    """Lets every call but the first pass."""

    params: ClassVar[Mapping[str, object]] = {'skip_first': None}

    @classmethod
    def initialize_context(cls, context: Context, **kwargs: object) -> None:
        super().initialize_context(context, **kwargs)
        context['first_has_been_skipped'] = False

    @staticmethod
    def should_log(context: Context) -> bool:
        passes = bool(context['first_has_been_skipped'])
        context['first_has_been_skipped'] = True
        return passes


class Throttle(LoggingFilter):
    """Lets at most one call in `throttle_duration_sec` pass; after a jump back of the clock the next call
    passes.
    """

    params: ClassVar[Mapping[str, object]] = {
        'throttle_duration_sec': None,
        'throttle_time_source_type': _SteadyClock(),
    }

    @classmethod
    def initialize_context(cls, context: Context, **kwargs: object) -> None:
        super().initialize_context(context, **kwargs)
        context['throttle_last_logged'] = None
        clock = context['throttle_time_source_type']
        if isinstance(clock, type) or not isinstance(clock, LogClock):
            raise ValueError(f'Received throttle_time_source_type of "{clock}" is not a clock instance')  # noqa: TRY004

    @staticmethod
    def should_log(context: Context) -> bool:
        clock = cast('LogClock', context['throttle_time_source_type'])
        duration = context['throttle_duration_sec']
        if not isinstance(duration, int | float):
            raise LoggingOptionError(f'throttle_duration_sec must be a number of seconds, got {duration!r}')
        now, last = clock.now().nanoseconds, context['throttle_last_logged']
        passes = not isinstance(last, int) or now < last or now >= last + duration * 1e9
        if passes:
            context['throttle_last_logged'] = now
        return passes


supported_filters: dict[str, type[LoggingFilter]] = {
    'throttle': Throttle,
    'skip_first': SkipFirst,
    'once': Once,
}
"""The filters by name, in the order in which they are asked."""

_ALL_PARAMS = [param for kind in supported_filters.values() for param in kind.params]


def get_filters_from_kwargs(**kwargs: object) -> list[str]:
    """Return the names of the filters that a call's options ask for.

    Raises LoggingOptionError (a TypeError) for an unknown option, and if an option that a filter needs is
    missing.
    """
    asked = []
    for name, kind in supported_filters.items():
        if not any(kwargs.get(param) for param in kind.params):
            continue
        asked.append(name)
        for param, default in kind.params.items():
            if default is None and param not in kwargs:
                raise LoggingOptionError(
                    f'required parameter "{param}" not specified '
                    f'but is required for the the logging filter "{name}"'
                )
    for param in kwargs:
        if param == 'severity':
            raise LoggingOptionError(
                "got multiple values for argument 'severity': the method's name says it; "
                'or call log(message, severity)'
            )
        if param not in _ALL_PARAMS:
            raise LoggingOptionError(
                f'parameter "{param}" is not one of the recognized logging options "{_ALL_PARAMS}"'
            )
    return asked
