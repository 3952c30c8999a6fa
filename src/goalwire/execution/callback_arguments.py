"""Checks the parameters of a callback when a program passes it, before it is first called.

The asyncio API refuses a callback that does not take the arguments it will get. rclpy accepts such a
callback, and raises when it calls it. So programs of rclpy get a warning in the log, and later the same error
as in rclpy.
"""

from __future__ import annotations

import sys
from types import CoroutineType, FunctionType, MethodType
from typing import TYPE_CHECKING

from goalwire.places import at, caller_place, function_place

if TYPE_CHECKING:
    from collections.abc import Callable
    from inspect import Signature

    from goalwire.logging import RcutilsLogger

CO_COROUTINE = 0x80
"""The value of inspect.CO_COROUTINE, copied because the import of inspect takes 10 ms."""

_VARIADIC = 0x04
"""The value of inspect.CO_VARARGS, which says that a function has *args."""


def check_callback(callback: object, arguments: tuple[str, ...], what: str) -> None:
    """Raise TypeError, as a call would, if `callback` does not accept `arguments`.

    `what` names the callback in the text; `arguments` are the names of the arguments that it will get.
    """
    problem = _problem(callback, arguments, what)
    if problem is not None:
        raise TypeError(problem)


def advise_callback(callback: object, arguments: tuple[str, ...], what: str, logger: RcutilsLogger) -> None:
    """Log a warning if `callback` cannot be called with these `arguments`. The call will raise TypeError.

    `what` names the callback in the text; `arguments` are the names of the arguments that it will get.
    """
    problem = _problem(callback, arguments, what)
    if problem is not None:
        logger.warning(f'{problem}; the call will fail{at(function_place(callback) or caller_place())}')


def _problem(callback: object, arguments: tuple[str, ...], what: str) -> str | None:
    """Return why `callback` cannot be called with these arguments; None if it can."""
    if not callable(callback):
        return f'{what} must be a function: {describe_given(callback)}'
    if accepts(callback, len(arguments)):
        return None
    name = getattr(callback, '__qualname__', None) or repr(callback)
    _, bound = function_of(callback)
    parameters = ', '.join((*('self',) * bound, *arguments))
    own = name.rpartition('.')[2]
    better = f'lambda {parameters}: …' if own == '<lambda>' else f'def {own}({parameters}):'
    return f"{what} is called as {name}({', '.join(arguments)}), and does not take that: write '{better}'"


def describe_given(callback: object) -> str:
    """Return a text that names the object given in place of a function, and the usual remedy."""
    if isinstance(callback, CoroutineType):
        callback.close()  # else Python warns that it was never awaited
        given = f'a coroutine of {callback.__qualname__}()'
    else:
        given = repr(callback)
    return f'got {given}; give the function itself, f and not f()'


def accepts(callback: Callable[..., object], count: int) -> bool:
    """Tell whether `callback` takes `count` positional arguments. A callback without a signature is assumed
    to take one.
    """
    arguments = _plain_arguments(callback)
    if arguments is not None:
        return count in arguments
    try:
        signature_of(callback).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # some builtins have no signature
        return count == 1
    return True


def function_of(callback: object) -> tuple[FunctionType | None, int]:
    """Return the plain function of a function or a method, and the number of arguments bound to it.

    Returns None and 0 for other callables. Most callbacks are functions or methods, so mostly inspect, whose
    import takes 5 ms, is not needed.
    """
    function, given = (callback.__func__, 1) if isinstance(callback, MethodType) else (callback, 0)
    return (function if isinstance(function, FunctionType) else None), given


def import_coroutine_runner(callback: object) -> None:
    """Import what runs coroutines if `callback` is an `async def`, so that its first call does not wait.

    The import takes 25 ms, and a second on a small or busy computer: too long for a program that moves a
    robot.
    """
    function, _ = function_of(callback)
    if function is not None and function.__code__.co_flags & CO_COROUTINE:
        import goalwire.execution.asyncio.coroutine_runner  # noqa: F401


def signature_of(callback: Callable[..., object]) -> Signature:
    """Return the signature of `callback`. Raises TypeError or ValueError if `callback` has none."""
    from inspect import signature

    if sys.version_info >= (3, 14):  # names imported only for type checkers have no value
        from annotationlib import Format

        return signature(callback, annotation_format=Format.STRING)
    return signature(callback)


def _plain_arguments(callback: object) -> range | None:
    """Return the possible numbers of positional arguments; None if only inspect can tell them."""
    function, bound = function_of(callback)
    if function is None or function.__dict__:  # a decorator may have set `__wrapped__` there
        return None
    code = function.__code__
    most = code.co_argcount - bound
    if code.co_kwonlyargcount or most < 0:
        return None
    least = max(most - len(function.__defaults__ or ()), 0)
    return range(least, sys.maxsize if code.co_flags & _VARIADIC else most + 1)
