"""Work that blocks, done in a thread while a coroutine waits for its end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

T = TypeVar('T')


async def in_thread(function: Callable[[], T]) -> T:
    """Call `function` in a thread and return or raise what it does.

    A thread cannot be stopped, so a cancellation takes effect when it has ended: nothing is left half done.
    """
    source = asyncio.ensure_future(asyncio.to_thread(function))
    cancellation: asyncio.CancelledError | None = None
    while not source.done():
        try:
            await asyncio.wait([source])
        except asyncio.CancelledError as error:
            cancellation = error
    if cancellation is None:
        return source.result()
    source.exception()  # looked at: the cancellation is told instead
    raise cancellation
