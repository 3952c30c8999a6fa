"""Coroutines that run another coroutine and clean up after it, even if that one never started."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable
from typing import Any, Self

from goalwire.rules import reasons
from goalwire.transport.contract import Request


class Answering(Coroutine[Any, Any, None]):
    """Runs a service's `async def` callback and sends what it returns.

    It steps `callback`; `answer(response, request)` gets what it returns, `failed(error)` what it raises.

    If the callback raises, or is cancelled or closed, the request is given up, even before the callback's
    first step. An `async def` that wraps it could not do that: it would not have begun, so its `finally`
    would not run.
    """

    __slots__ = ('_answer', '_callback', '_failed', '_on_cancel', '_request')

    def __init__(
        self,
        callback: Coroutine[Any, Any, object],
        request: Request,
        answer: Callable[[object, Request], None],
        failed: Callable[[Exception], None] | None = None,
        on_cancel: Callable[[], object] = bool,
    ) -> None:
        """Without `failed`, the callback's errors propagate. `on_cancel` is called if the request is
        cancelled.
        """
        self._callback = callback
        self._request = request
        self._answer = answer
        self._failed = failed
        self._on_cancel = on_cancel

    def send(self, value: Any) -> Any:
        """Resume the inner coroutine, as every `send` does."""
        return self._step(self._callback.send, value)

    def throw(self, *error: Any) -> Any:
        """Raise an error in the inner coroutine, as `throw` of every coroutine does."""
        return self._step(self._callback.throw, *error)

    def close(self) -> None:
        """End the coroutine at its present await."""
        try:
            self._callback.close()
        finally:
            self._cancel(reasons.STOPPED)

    def _cancel(self, reason: str) -> None:
        self._on_cancel()
        self._request.cancel(reason)

    def __await__(self) -> Self:
        return self

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Any:
        return self._step(self._callback.send, None)

    def _step(self, step: Callable[..., Any], *sent: Any) -> Any:
        try:
            try:
                return step(*sent)
            except StopIteration as end:
                response = end.value
            self._answer(response, self._request)
        except BaseException as error:
            self._cancel(reasons.explain_failure(error))
            if self._failed is None or not isinstance(error, Exception):
                raise
            self._failed(error)
        raise StopIteration


class Enclosing(Coroutine[Any, Any, None]):
    """Steps the coroutine `outer`. If `outer` is closed before its first step, the coroutines that it would
    have awaited are closed, too.

    Python warns of a coroutine that was never awaited, and an `async def` that has not begun cannot close
    one.
    """

    __slots__ = ('_inner', '_outer')

    def __init__(
        self, outer: Coroutine[Any, Any, None], inner: Iterable[Coroutine[Any, Any, object]]
    ) -> None:
        self._outer = outer
        self._inner = tuple(inner)

    def send(self, value: Any) -> Any:
        """Resume the inner coroutine, as every `send` does."""
        return self._outer.send(value)

    def throw(self, *error: Any) -> Any:
        """Raise an error in `outer`, as coroutines do. If `outer` has not begun, it ends at once."""
        try:
            return self._outer.throw(*error)
        except BaseException:
            self._close_inner()
            raise

    def close(self) -> None:
        """End the coroutine at its present await."""
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
        return self._outer.send(None)
