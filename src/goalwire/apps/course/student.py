"""A student's program as a process of its own, on a graph where it meets only the check."""

from __future__ import annotations

import asyncio
import os
import sys
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from goalwire.apps.course.failures import Failure, find_failure
from goalwire.errors import ServerLostError

if TYPE_CHECKING:
    from types import TracebackType

T = TypeVar('T')

_KEPT_LINES = 2000
_SHOWN_LINES = 6
_LONGEST_LINE = 10_000
_FAILS_WITHIN = 2.0
"""Seconds that a failing program has to write its traceback and end."""


class Wrong(Exception):
    """Something in a student's program is not as the task wants it. `advice` says what to look at."""

    def __init__(self, problem: str, advice: str) -> None:
        super().__init__(problem)
        self.advice = advice


class Student:
    """A student's program; `async with Student(file) as student:` runs it, and kills it afterwards."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._output: deque[str] = deque(maxlen=_KEPT_LINES)

    async def __aenter__(self) -> Self:
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            self._file.name,
            cwd=self._file.parent,
            env={**os.environ, 'PYTHONUNBUFFERED': '1', 'PYTHONIOENCODING': 'utf-8'},
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
            limit=_LONGEST_LINE,
        )
        self._end = asyncio.create_task(self._follow())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(ProcessLookupError):
            self._process.kill()
        await self._end

    async def _follow(self) -> int:
        """Read what the program prints until it has ended; return its exit code."""
        output = self._process.stdout
        assert output is not None
        while chunk := await output.read(_LONGEST_LINE):
            self._output.append(chunk.decode('utf-8', 'replace'))
        return await self._process.wait()

    @property
    def output(self) -> str:
        """The output so far, errors included. Of long output only the end is kept."""
        return ''.join(self._output)

    def last_lines(self) -> str:
        """Return the last lines of the program's output, for an error message."""
        lines = [line for line in self.output.splitlines() if line.strip()]
        return '\n'.join(f'    | {line}' for line in lines[-_SHOWN_LINES:]) or '    | (it printed nothing)'

    async def failure(self) -> Failure | None:
        """Return the exception that the program has shown, if any. This ends the program.

        The failed answer may arrive before the program has written its traceback. So wait until the program
        ends, kill it after `_FAILS_WITHIN` s if necessary, and read its output to the end.
        """
        await asyncio.wait({self._end}, timeout=_FAILS_WITHIN)
        with suppress(ProcessLookupError):
            self._process.kill()
        await self._end
        return self._find_failure()

    def _find_failure(self) -> Failure | None:
        return find_failure(self.output, self._file.name)

    async def during(self, waiting: Coroutine[Any, Any, T], doing: str) -> T:
        """Return the result of `waiting`. Raises Wrong if the program ends first.

        `doing` says what the program should do meanwhile, such as 'move the arm'.
        """
        task = asyncio.create_task(waiting)
        if await self.is_first(task) and not await self._is_lost(task.exception()):
            return task.result()
        code = self._end.result()
        question = 'is rclpy.spin(node) there, and not spin_once? ' if code == 0 else ''
        problem = f'the program ended with exit code {code} while it should {doing}'
        if failure := self._find_failure():
            raise Wrong(f'{problem}: {failure.text}', failure.advice or 'mend what raises it')
        raise Wrong(
            problem,
            f'{question}The end of what it printed:\n{self.last_lines()}',
        )

    async def _is_lost(self, error: BaseException | None) -> bool:
        """Return True if an error means that the program ends, perhaps a little later than its server."""
        if isinstance(error, ServerLostError):
            await asyncio.wait({self._end}, timeout=_FAILS_WITHIN)
        return isinstance(error, ServerLostError) and self._end.done()

    async def is_first(self, task: asyncio.Task[T]) -> bool:
        """Wait until the task or the program ends. Return False, and cancel the task, if it is not first."""
        try:
            await asyncio.wait({task, self._end}, return_when=asyncio.FIRST_COMPLETED)
            return task.done()
        finally:
            task.cancel()
            await asyncio.wait({task})

    async def wait(self, within: float, advice: Callable[[], str]) -> int:
        """Return the program's exit code. Raises Wrong with `advice()` if it runs longer than `within` s."""
        done, _ = await asyncio.wait({self._end}, timeout=within)
        if not done:
            raise Wrong(f'the program has not ended after {within:g} s', advice())
        if 'Traceback (most recent call last)' in self.output:
            problem, failure = 'the program ended with an exception that nothing caught', self._find_failure()
            if failure is not None and failure.advice:
                raise Wrong(f'{problem}: {failure.text}', failure.advice)
            raise Wrong(problem, f'the end of what it printed:\n{self.last_lines()}')
        return self._end.result()
