"""Refreshes a browser's page as fast as the browser can show it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from time import monotonic

from nicegui import Client

_ANSWER_S = 5.0
"""Seconds that a browser may take to show a frame before it is asked again."""
_ACKNOWLEDGE = 'return await new Promise(done => requestAnimationFrame(() => done(1)))'


class Pacer:
    """Refreshes a page again and again, each time after the browser has shown the last refresh.

    So at most one refresh is on its way, and a slow browser gets little data and delays no other browser.
    While a browser does not answer, it gets only the question whether it has shown the refresh.
    """

    def __init__(self, client: Client, refresh: Callable[[], float]) -> None:
        """`refresh` returns the seconds until its next call; a slow browser makes them longer."""
        self._client = client
        self._refresh = refresh
        self._changed = asyncio.Event()
        self._closed = False

    async def run(self) -> None:
        """Refresh until `close`."""
        await self._client.connected()
        while not self._closed:
            began = monotonic()
            with self._client:
                period = self._refresh()
            while not await self._has_answered():
                pass
            left = period - (monotonic() - began)
            self._changed.clear()
            try:
                async with asyncio.timeout(max(left, 0.01)):
                    await self._changed.wait()
            except TimeoutError:
                continue

    async def _has_answered(self) -> bool:
        """Wait for the browser's next frame; True if it came in time, or if the page is closed."""
        try:
            await self._client.run_javascript(_ACKNOWLEDGE, timeout=_ANSWER_S)
        except TimeoutError:
            return self._closed
        return True

    def refresh_soon(self) -> None:
        """Refresh at once, without waiting for the rest of the period."""
        self._changed.set()

    def close(self) -> None:
        """Stop refreshing, because the browser has gone."""
        self._closed = True
        self._changed.set()
