"""The base of all filters, which passes messages to registered callbacks."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

__all__ = ['SimpleFilter']


class SimpleFilter:
    """The base of filters: it passes messages to the registered callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., object], tuple[object, ...]]] = {}
        self._connections = count()

    def registerCallback(self, cb: Callable[..., object], *args: object) -> int:
        """Call `cb(*messages, *args)` with each output from now on; return `cb`'s key in `callbacks`."""
        connection = next(self._connections)
        self.callbacks[connection] = cb, args
        return connection

    def signalMessage(self, *msg: object) -> None:
        """Call the callbacks with the messages, in the order of the callbacks' registration."""
        for callback, args in list(self.callbacks.values()):
            callback(*msg, *args)
