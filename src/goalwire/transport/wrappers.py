"""Wrappers around every transport of this process, such as the faults of `with faults:`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from goalwire.transport.contract import Transport

Wrapper: TypeAlias = Callable[[Transport], Transport]
_wrappers: tuple[Wrapper, ...] = ()


def add(wrapper: Wrapper) -> Callable[[], None]:
    """Put `wrapper` around transports from now on; return a function that takes it away."""
    global _wrappers  # noqa: PLW0603 - which transports there are is a matter of the process
    _wrappers += (wrapper,)

    def remove() -> None:
        global _wrappers  # noqa: PLW0603
        _wrappers = tuple(each for each in _wrappers if each is not wrapper)

    return remove


def wrap(transport: Transport) -> Transport:
    """Return a transport inside all wrappers that were added; the first that was added is the innermost."""
    for wrapper in _wrappers:
        transport = wrapper(transport)
    return transport
