"""launch_testing: decorators for tests, and for the function that returns the launch description."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

__all__ = ['parametrize', 'post_shutdown_test', 'ready_to_test_action_timeout']

T = TypeVar('T')
TIMEOUT = '__ready_to_test_action_timeout__'


def post_shutdown_test() -> Callable[[type[T]], type[T]]:
    """Mark a class of tests that run after all processes have ended. Raises TypeError for a function."""

    def decorate(test_item: type[T]) -> type[T]:
        if not isinstance(test_item, type):
            raise TypeError('postcondition_test should decorate test classes')
        test_item.__post_shutdown_test__ = True  # type: ignore[attr-defined]
        return test_item

    return decorate


def ready_to_test_action_timeout(timeout: float) -> Callable[[T], T]:
    """Set how many seconds the launch may take until ReadyToTest; the default is 15."""

    def decorate(function: T) -> T:
        setattr(function, TIMEOUT, timeout)
        return function

    return decorate


def parametrize(argnames: str, argvalues: Iterable[Any]) -> Callable[[Callable[..., Any]], Callable[[], Any]]:
    """Run the whole launch once for each of the given values, as pytest.mark.parametrize does with a test."""
    names = [name.strip() for name in argnames.split(',') if name.strip()]
    values = [value if isinstance(value, tuple) else (value,) for value in argvalues]

    def decorate(function: Callable[..., Any]) -> Callable[[], Any]:
        @functools.wraps(function)
        def descriptions() -> Iterator[tuple[Callable[..., Any], dict[str, Any]]]:
            for value in values:
                given = dict(zip(names, value, strict=False))
                bound = functools.partial(function, **given)
                functools.update_wrapper(bound, function)
                yield bound, given

        descriptions.__parametrized__ = True  # type: ignore[attr-defined]
        return descriptions

    return decorate
