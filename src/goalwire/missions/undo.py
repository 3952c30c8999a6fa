"""The undo of a mission: steps that run in reverse order if a later step fails."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from goalwire.errors import MissionStopped

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self


class Undo:
    """A block with undo steps: `async with m.undo() as undo:`. Steps.undo makes it.

    The pushed steps run, the latest first, if the block fails, or if the mission gives up, is cancelled or
    runs out of time. They do not run if only the runner or the machine ends: then the mission goes on later.
    If one of them fails, the others run nevertheless, and the error of the block is raised.
    """

    def __init__(self, undoing: Callable[[], AbstractContextManager[None]]) -> None:
        """`undoing()` is a context manager: steps in its block run although the mission was stopped."""
        self._undoing = undoing
        self._pushed: list[Callable[[], Awaitable[Any]]] = []

    def push(self, function: Callable[..., Awaitable[Any]], /, *arguments: Any, **fields: Any) -> None:
        """Add a step that undoes another one: `undo.push(grip.call, position=0.05)`."""
        self._pushed.append(lambda: function(*arguments, **fields))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not isinstance(error, Exception):
            return  # the block has succeeded, or the runner is ending
        if isinstance(error, MissionStopped) and not error.undo:
            return
        with self._undoing():
            for undo in reversed(self._pushed):
                try:
                    await undo()
                except Exception as failure:
                    error.add_note(f'an undo step failed: {type(failure).__name__}: {failure}')
