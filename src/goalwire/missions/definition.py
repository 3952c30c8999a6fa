"""The decorator of missions, and the fingerprint that shows if their code has changed."""

from __future__ import annotations

import inspect
from collections.abc import Awaitable, Callable
from hashlib import sha256
from typing import TYPE_CHECKING, Any, TypeAlias

from goalwire.records import record

if TYPE_CHECKING:
    import goalwire
    from goalwire.rules.missions.holding import Resume

MissionFunction: TypeAlias = 'Callable[..., Awaitable[Any]]'
"""A mission's function: `async def mission(m, *arguments)`. It returns a value that JSON can hold."""
ResumeCheck: TypeAlias = 'Callable[[goalwire.Node], Awaitable[bool | str]]'
"""A check whether the mission may go on. It returns True if so, else False or a text with the reason."""


@record
class Definition:
    """A mission's function and the arguments of its decorator. `mission` makes it."""

    function: MissionFunction
    name: str
    version: int
    resume: Resume
    resume_check: ResumeCheck | None
    timeout: float | None

    def __call__(self, steps: object, *arguments: Any) -> Awaitable[Any]:
        """Call the function."""
        return self.function(steps, *arguments)

    @property
    def fingerprint(self) -> str:
        """A hash of the function's source; '' if its source cannot be read."""
        try:
            source = inspect.getsource(self.function)
        except (OSError, TypeError):
            return ''
        return sha256(source.encode()).hexdigest()[:16]


def mission(
    *,
    version: int = 1,
    resume: Resume = 'ask',
    resume_check: ResumeCheck | None = None,
    timeout: float | None = None,
    name: str | None = None,
) -> Callable[[MissionFunction], Definition]:
    """Make an `async def` function a mission: `@mission(version=1)`.

    After a reboot of the machine, or if the runner was away for more than 60 s, a mission with `resume='ask'`
    waits for a person before anything moves; with 'auto' it goes on. After every restart of the runner
    `resume_check(node)` is awaited first; if it does not return True, the mission is held. The whole mission
    may take `timeout` s, including the time without a runner; then it is stopped, and its undo steps run.
    `name` is the mission's name in the journal, by default that of the function.

    Raises TypeError for anything but an `async def` function, ValueError for another `resume`.
    """
    if resume not in {'ask', 'auto'}:
        raise ValueError(f"resume is 'ask' or 'auto', not {resume!r}")

    def define(function: MissionFunction) -> Definition:
        if not inspect.iscoroutinefunction(function):
            raise TypeError('a mission is an `async def` function: async def fetch(m, shelf): …')
        return Definition(function, name or function.__name__, version, resume, resume_check, timeout)

    return define
