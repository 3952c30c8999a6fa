"""launch_testing.markers: mark launches that stay alive, and tests that are repeated after a failure."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import Any, TypeVar

__all__ = ['keep_alive', 'retry_on_failure']

T = TypeVar('T')


def keep_alive(test_description: T) -> T:
    """Mark a description whose launch continues after all its processes have ended."""
    markers = getattr(test_description, '__markers__', {})
    test_description.__markers__ = {**markers, 'keep_alive': True}  # type: ignore[attr-defined]
    return test_description


def retry_on_failure(
    *, times: int, delay: float | None = None
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Run a test again if it raises AssertionError: at most `times` runs in all, `delay` seconds apart."""
    if times <= 0:
        raise AssertionError(f'times is {times}: it must be above 0')

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(function)
        def retry(self: Any, *args: Any, **kwargs: Any) -> Any:
            for _ in range(times - 1):
                try:
                    return function(self, *args, **kwargs)
                except AssertionError:
                    if delay is not None:
                        time.sleep(delay)
            return function(self, *args, **kwargs)

        return retry

    return decorate
