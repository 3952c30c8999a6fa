"""The decorator of missions, and the fingerprint by which changed code is known."""

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
"""`async def mission(m, *arguments)`. It returns a value that JSON can hold."""
ResumeCheck: TypeAlias = 'Callable[[goalwire.Node], Awaitable[bool | str]]'
"""Says whether the world allows the mission to go on: False, or a text that says why not."""


@record
class Definition:
    """A mission's function and what its decorator says. Made by `mission`."""

    function: MissionFunction
    name: str
    version: int
    resume: Resume
    resume_check: ResumeCheck | None
    timeout: float | None

    def __call__(self, steps: object, *arguments: Any) -> Awaitable[Any]:
        """Begin the function."""
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

    After a reboot of the machine, and where the runner was away for more than 60 s, a mission with
    `resume='ask'` waits for a person before anything moves; with 'auto' it goes on. `resume_check(node)` is
    awaited before it goes on after any restart of its runner, and holds the mission if it says no. The whole
    mission may take `timeout` s, the time without a runner included; then it is stopped, and its undo steps
    run. `name` is what the journal knows it by, the function's own by default.

    Raises TypeError for anything but an `async def` function, ValueError for another `resume`.
    """
    if resume not in {'ask', 'auto'}:
        raise ValueError(f"resume is 'ask' or 'auto', not {resume!r}")

    def define(function: MissionFunction) -> Definition:
        if not inspect.iscoroutinefunction(function):
            raise TypeError('a mission is an `async def` function: async def fetch(m, shelf): …')
        return Definition(function, name or function.__name__, version, resume, resume_check, timeout)

    return define
