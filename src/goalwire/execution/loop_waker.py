"""How a coroutine under asyncio waits for a future that any thread may complete."""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Protocol
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Generator

    from goalwire.execution.asyncio_loop_waker import AsyncioLoopWaker, LoopWaker


class Awaitable(Protocol):
    """What can be waited for: it calls its wakers once it is no longer pending."""

    def pending(self) -> bool: ...

    def add_waker(self, waker: Callable[[], None]) -> None: ...

    def remove_waker(self, waker: Callable[[], None]) -> None: ...


WAKE_FDS: set[int] = set()
"""The descriptors by which loops are woken here. Virtual time takes them for the loops' own."""

_wakers: WeakKeyDictionary[asyncio.AbstractEventLoop, AsyncioLoopWaker] = WeakKeyDictionary()


def waker_of(loop: asyncio.AbstractEventLoop) -> LoopWaker:
    """The bridge to `loop`: a runner's own, else the one that all who come here share."""
    own: LoopWaker | None = getattr(loop, 'goalwire_waker', None)
    return shared_waker(loop) if own is None else own


def shared_waker(loop: asyncio.AbstractEventLoop) -> AsyncioLoopWaker:
    """The bridge to a loop that is none of ours."""
    waker = _wakers.get(loop)
    if waker is None:
        from goalwire.execution.asyncio_loop_waker import AsyncioLoopWaker

        waker = _wakers[loop] = AsyncioLoopWaker(loop)
    return waker


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The asyncio loop that runs on this thread; does not import asyncio to find out."""
    # Another thread may be in the middle of importing it: then no loop runs yet.
    get: Callable[[], asyncio.AbstractEventLoop | None] | None
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else get()


def wait_on(loop: asyncio.AbstractEventLoop, future: Awaitable) -> Generator[object, None, None]:
    """Suspend the running asyncio task until `future` is no longer pending."""
    waker = waker_of(loop)
    direct = waker.direct(loop=loop)
    wake = partial(waker.call, direct.resume)
    future.add_waker(wake)
    try:
        yield from direct
    finally:
        future.remove_waker(wake)
