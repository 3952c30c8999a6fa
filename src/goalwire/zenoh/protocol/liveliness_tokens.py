"""Liveliness tokens: the tokens that exist, and the watchers that are told of changes.

A token is a declared key. It appears with its first declaration, on any link or by the session itself. It
vanishes when its last declaration is taken back or loses its link. So declarations are counted for each key.

A new watcher is told of the tokens that exist. A program that looks at a fleet knows a hundred thousand,
and each of its action clients watches the few of one topic. So tokens are also kept by the beginning of their
keys, and a watcher is compared with those alone that begin as its own expression does.
"""

from __future__ import annotations

from collections.abc import Callable

from goalwire.concurrency.ordered_dispatcher import OrderedDispatcher
from goalwire.zenoh.protocol.bodies import Sample
from goalwire.zenoh.protocol.key_expressions import intersects, is_wild, plain_head
from goalwire.zenoh.protocol.key_index import KeyIndex

Watcher = Callable[[Sample], None]


class Liveliness:
    """Tokens and watchers. All methods except `tell` are called with the session's lock held."""

    def __init__(self, callback_failed: Callable[[Exception], None]) -> None:
        self._callback_failed = callback_failed
        self._declared: dict[str, int] = {}
        self._by_head: dict[str, dict[str, None]] = {}
        """The tokens by `plain_head`."""
        self._watchers: KeyIndex[Watcher] = KeyIndex()
        self._changes: OrderedDispatcher[tuple[Watcher, Sample]] = OrderedDispatcher(self._deliver)
        self.tell = self._changes.drain
        """Tell the watchers of the changes since the last call, in order."""

    def appeared(self, key: str) -> None:
        """Count one more declaration of a token."""
        count = self._declared.get(key, 0)
        self._declared[key] = count + 1
        if not count:
            self._by_head.setdefault(plain_head(key), {})[key] = None
            self._post(Sample(key, b''))

    def vanished(self, key: str) -> None:
        """Count one declaration of a token less."""
        count = self._declared.pop(key, 0) - 1
        if count > 0:
            self._declared[key] = count
        elif not count:
            head = plain_head(key)
            tokens = self._by_head.get(head, {})
            tokens.pop(key, None)
            if not tokens:
                self._by_head.pop(head, None)
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
        if head := plain_head(key):
            found = [*self._by_head.get(head, ()), *self._by_head.get('', ())]
        else:
            found = list(self._declared)
        return [token for token in found if intersects(token, key)]
