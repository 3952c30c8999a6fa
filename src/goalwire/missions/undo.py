"""What takes back what a mission did: steps that run in reverse order if what follows them fails."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from goalwire.errors import MissionStopped

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self


class Undo:
    """`async with m.undo() as undo:`. Made by Steps.undo.

    If the block fails, if the mission gives up, is cancelled or its time is over, the pushed steps run, the
    latest first. They do not run because a runner ends, or its machine: then the mission goes on later. If
    one of them fails, those before it run nevertheless, and the first error of the block is raised.
    """

    def __init__(self, undoing: Callable[[], AbstractContextManager[None]]) -> None:
        """Steps that run in a block of `undoing()` run although the mission was stopped."""
        self._undoing = undoing
        self._pushed: list[Callable[[], Awaitable[Any]]] = []

    def push(self, function: Callable[..., Awaitable[Any]], /, *arguments: Any, **fields: Any) -> None:
        """Have a step taken back by another one: `undo.push(grip.call, position=0.05)`."""
        self._pushed.append(lambda: function(*arguments, **fields))

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if not isinstance(error, Exception):
            return  # all went well, or the runner ends
        if isinstance(error, MissionStopped) and not error.undo:
            return
        with self._undoing():
            for undo in reversed(self._pushed):
                try:
                    await undo()
                except Exception as failure:
                    error.add_note(f'an undo step failed: {type(failure).__name__}: {failure}')
