"""Keeps clients of services and actions for later calls, because finding a server takes time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, Protocol, TypeVar

MOST = 64
"""The largest number of idle clients that are kept."""


class Closeable(Protocol):
    """A client that can be closed."""

    def close(self) -> None:
        """Close the client."""


ClientT = TypeVar('ClientT', bound=Closeable)


class Pool(Generic[ClientT]):
    """Makes a client for each name and type when it is first borrowed. Only for the loop's thread."""

    def __init__(self) -> None:
        self._clients: dict[tuple[str, str], ClientT] = {}
        """The idle clients, the last used one at the end."""
        self._users: dict[tuple[str, str], int] = {}

    @contextmanager
    def borrow(self, name: str, type_name: str, make: Callable[[], ClientT]) -> Iterator[ClientT]:
        """Lend the client of a name and a type for the block; several borrowers may share it."""
        key = name, type_name
        client = self._clients.pop(key, None) or make()
        self._clients[key] = client
        self._users[key] = self._users.get(key, 0) + 1
        try:
            yield client
        finally:
            if key in self._users:  # false if `close` was called during the block
                self._users[key] -= 1
                self._close_some()

    def _close_some(self) -> None:
        idle = [key for key in self._clients if not self._users[key]]
        for key in idle[: max(0, len(idle) - MOST)]:
            del self._users[key]
            self._clients.pop(key).close()

    def close(self) -> None:
        """End every client; calls that are under way fail."""
        for client in self._clients.values():
            client.close()
        self._clients.clear()
        self._users.clear()
