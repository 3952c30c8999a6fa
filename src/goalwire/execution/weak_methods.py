"""Methods that do not keep their objects alive.

The wire and the graph hold what they call. If that held the node, a node that a program drops would stay in
the graph for ever. So they hold an entity's methods through these, and the node holds the entity.
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
    """Return what gives the object of a bound method, held weakly, and the method's function; else None.

    hot path: who calls the two saves the call of `weakly`.
    """
    if not isinstance(handle, MethodType):
        return None
    return ref(handle.__self__), handle.__func__
