"""How a coroutine under asyncio waits for a future that any thread may complete."""

from __future__ import annotations

import sys
from collections import deque
from typing import TYPE_CHECKING, Protocol, cast
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Generator


class Awaitable(Protocol):
    """What can be waited for: it calls its wakers once it is no longer pending."""

    def pending(self) -> bool: ...

    def add_waker(self, waker: Callable[[], None]) -> None: ...

    def remove_waker(self, waker: Callable[[], None]) -> None: ...


class Bridge:
    """Hands completions from any thread to one asyncio loop, many with one wake-up.

    `wake` gets `drain` called soon on the loop's thread; it may be called on any thread.
    """

    __slots__ = ('__weakref__', '_done', '_wake', '_woken')

    def __init__(self, wake: Callable[[Callable[[], None]], object]) -> None:
        self._wake = wake
        self._done: deque[asyncio.Future[None]] = deque()
        self._woken = False

    def complete(self, waiter: asyncio.Future[None]) -> None:
        """Complete `waiter` on its loop."""
        self._done.append(waiter)
        if not self._woken:
            self._woken = True
            try:
                self._wake(self.drain)
            except RuntimeError:
                self._done.clear()  # the loop is closed: nobody waits there any more

    def drain(self) -> None:
        """Complete what has gathered; on the loop's thread."""
        self._woken = False
        while self._done:
            waiter = self._done.popleft()
            if not waiter.done():
                waiter.set_result(None)


_foreign: WeakKeyDictionary[asyncio.AbstractEventLoop, Bridge] = WeakKeyDictionary()


def bridge_to(loop: asyncio.AbstractEventLoop) -> Bridge:
    """The bridge to `loop`: its own if it is one of ours, else one over `call_soon_threadsafe`."""
    own = getattr(loop, 'bridge', None)
    if isinstance(own, Bridge):
        return own
    bridge = _foreign.get(loop)
    if bridge is None:
        bridge = _foreign[loop] = Bridge(loop.call_soon_threadsafe)
    return bridge


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The asyncio loop that runs on this thread; does not import asyncio to find out."""
    # Another thread may be in the middle of importing it: then no loop runs yet.
    get = getattr(sys.modules.get('asyncio.events'), '_get_running_loop', None)
    return None if get is None else cast('asyncio.AbstractEventLoop | None', get())


def wait_on(loop: asyncio.AbstractEventLoop, future: Awaitable) -> Generator[object, None, None]:
    """Suspend the running asyncio task until `future` is no longer pending."""
    bridge = bridge_to(loop)
    waiter: asyncio.Future[None] = loop.create_future()

    def wake() -> None:
        bridge.complete(waiter)

    future.add_waker(wake)
    try:
        yield from waiter
    finally:
        future.remove_waker(wake)
