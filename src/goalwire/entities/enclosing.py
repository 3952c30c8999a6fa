"""A coroutine that awaits others, and does not leave them behind."""

from __future__ import annotations

from collections.abc import Coroutine, Iterable
from typing import Any, Self


class Enclosing(Coroutine[Any, Any, None]):
    """Steps `outer`. Closed before its first step, it closes those that `outer` would have awaited.

    Python warns of a coroutine that was never awaited, and an `async def` that has not begun cannot close it.
    """

    __slots__ = ('_inner', '_outer')

    def __init__(
        self, outer: Coroutine[Any, Any, None], inner: Iterable[Coroutine[Any, Any, object]]
    ) -> None:
        self._outer = outer
        self._inner = tuple(inner)

    def send(self, value: Any) -> Any:
        """Go on, as coroutines do."""
        return self._outer.send(value)

    def throw(self, *error: Any) -> Any:
        """Go on with an error, as coroutines do: one that has not begun ends by it at once."""
        try:
            return self._outer.throw(*error)
        except BaseException:
            self._close_inner()
            raise

    def close(self) -> None:
        """End it where it is."""
        try:
            self._outer.close()
        finally:
            self._close_inner()

    def _close_inner(self) -> None:
        for coroutine in self._inner:
            coroutine.close()

    def __await__(self) -> Self:
        return self

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Any:
        return self.send(None)
