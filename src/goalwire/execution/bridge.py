"""How a coroutine under asyncio waits for a future that any thread may complete."""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Protocol
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Generator

    from goalwire.execution.asyncio_bridge import Bridge, LoopBridge


class Awaitable(Protocol):
    """What can be waited for: it calls its wakers once it is no longer pending."""

    def pending(self) -> bool: ...

    def add_waker(self, waker: Callable[[], None]) -> None: ...

    def remove_waker(self, waker: Callable[[], None]) -> None: ...


BELLS: set[int] = set()
"""The descriptors by which loops are woken here. Virtual time takes them for the loops' own."""

_bridges: WeakKeyDictionary[asyncio.AbstractEventLoop, LoopBridge] = WeakKeyDictionary()


def bridge_to(loop: asyncio.AbstractEventLoop) -> Bridge:
    """The bridge to `loop`: a lane's own, else the one that all who come here share."""
    own: Bridge | None = getattr(loop, 'goalwire_bridge', None)
    return shared_bridge(loop) if own is None else own


def shared_bridge(loop: asyncio.AbstractEventLoop) -> LoopBridge:
    """The bridge to a loop that is none of ours."""
    bridge = _bridges.get(loop)
    if bridge is None:
        from goalwire.execution.asyncio_bridge import LoopBridge

        bridge = _bridges[loop] = LoopBridge(loop)
    return bridge


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The asyncio loop that runs on this thread; does not import asyncio to find out."""
    # Another thread may be in the middle of importing it: then no loop runs yet.
    get: Callable[[], asyncio.AbstractEventLoop | None] | None
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else get()


def wait_on(loop: asyncio.AbstractEventLoop, future: Awaitable) -> Generator[object, None, None]:
    """Suspend the running asyncio task until `future` is no longer pending."""
    bridge = bridge_to(loop)
    pause = bridge.pause(loop=loop)
    wake = partial(bridge.call, pause.resume)
    future.add_waker(wake)
    try:
        yield from pause
    finally:
        future.remove_waker(wake)
