"""Methods that do not keep their objects alive.

The wire and the graph keep the functions that they call. If these kept the node alive, a node that a program
drops would stay in the graph for ever. So the wire and the graph refer to methods of entities only weakly,
and only the node keeps its entities alive.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MethodType
from typing import Any, ParamSpec, TypeVar
from weakref import WeakMethod, ref

P = ParamSpec('P')
E = TypeVar('E')


def weakly(method: Callable[P, object]) -> Callable[P, None]:
    """Return a function that calls a bound method, and does nothing once its object has gone."""
    reference = WeakMethod(method)

    def call(*args: P.args, **kwargs: P.kwargs) -> None:
        alive = reference()
        if alive is not None:
            alive(*args, **kwargs)

    return call


def weak_parts(
    handle: Callable[[E], object],
) -> tuple[Callable[[], object | None], Callable[[Any, E], object]] | None:
    """Return a weak reference to the object of a bound method, and its function; None for other callables.

    hot path: a caller of the two parts saves the call of the function that `weakly` returns.
    """
    if not isinstance(handle, MethodType):
        return None
    return ref(handle.__self__), handle.__func__
