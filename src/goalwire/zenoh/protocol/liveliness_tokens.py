"""Liveliness tokens: the tokens that exist, and the watchers that are told of changes.

A token is a declared key. It appears with its first declaration, on any link or by the session itself. It
vanishes when its last declaration is taken back or loses its link. So declarations are counted for each key.
"""

from __future__ import annotations

from collections.abc import Callable

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.zenoh.protocol.key_expressions import intersects, is_wild
from goalwire.zenoh.protocol.key_index import KeyIndex
from goalwire.zenoh.protocol.network import Sample

Watcher = Callable[[Sample], None]


class Liveliness:
    """Tokens and watchers. All methods except `tell` are called with the session's lock held."""

    def __init__(self, callback_failed: Callable[[Exception], None]) -> None:
        self._callback_failed = callback_failed
        self._declared: dict[str, int] = {}
        self._watchers: KeyIndex[Watcher] = KeyIndex()
        self._changes: OrderedDispatcher[tuple[Watcher, Sample]] = OrderedDispatcher(self._deliver)
        self.tell = self._changes.drain
        """Tell the watchers of the changes since the last call, in order."""

    def appeared(self, key: str) -> None:
        """Count one more declaration of a token."""
        count = self._declared.get(key, 0)
        self._declared[key] = count + 1
        if not count:
            self._post(Sample(key, b''))

    def vanished(self, key: str) -> None:
        """Count one declaration of a token less."""
        count = self._declared.pop(key, 0) - 1
        if count > 0:
            self._declared[key] = count
        elif not count:
            self._post(Sample(key, None))

    def _post(self, change: Sample) -> None:
        for _, watcher in self._watchers.meeting(change.key):
            self._changes.post((watcher, change))

    def _deliver(self, change: tuple[Watcher, Sample]) -> None:
        """Call a watcher. An error of one watcher must not keep the others from being called."""
        watcher, sample = change
        try:
            watcher(sample)
        except Exception as error:
            self._callback_failed(error)

    def watch(self, number: int, key: str, watcher: Watcher, *, history: bool) -> None:
        """Call `watcher` with each change; with `history` also with the existing tokens."""
        self._watchers.add(number, key, watcher)
        if history:
            for token in self.present(key):
                self._changes.post((watcher, Sample(token, b'')))

    def unwatch(self, number: int) -> None:
        """Remove a watcher."""
        self._watchers.pop(number)

    def present(self, key: str) -> list[str]:
        """Return the existing tokens that match `key`."""
        if not is_wild(key):
            return [key] if key in self._declared else []
        return [token for token in list(self._declared) if intersects(token, key)]
