"""Telling interested parties, with no lock held."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Generic, ParamSpec

from goalwire.transport.reports import report_failure

P = ParamSpec('P')


class Watch(Generic[P]):
    """One party's interest; `close` ends it."""

    def __init__(self, watchers: Watchers[P], callback: Callable[P, object]) -> None:
        self._watchers = watchers
        self.callback = callback

    def close(self) -> None:
        """Be told no more, a call under way aside. Idempotent."""
        self._watchers.remove(self)


class Watchers(Generic[P]):
    """The parties interested in one kind of event."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._watches: tuple[Watch[P], ...] = ()

    def add(self, callback: Callable[P, object]) -> Watch[P]:
        """Tell `callback` from now on."""
        watch = Watch(self, callback)
        with self._lock:
            self._watches += (watch,)
        return watch

    def remove(self, watch: Watch[P]) -> None:
        """Forget one interest; an unknown one is no error."""
        with self._lock:
            self._watches = tuple(each for each in self._watches if each is not watch)

    def tell(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call everybody in the order they came. What one raises is logged and spares the others."""
        for watch in self._watches:
            try:
                watch.callback(*args, **kwargs)
            except Exception as error:
                report_failure('graph callback', error)
