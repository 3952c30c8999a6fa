"""Runs a program's main function in a thread of the test."""

from __future__ import annotations

import asyncio
import inspect
import sys
import threading
from typing import TYPE_CHECKING, Any

from goalwire.errors import ExternalShutdownException, RCLError
from goalwire.testing.log import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Sequence


class Program:
    """A program's `main()`, plain or `async def`, that runs in a thread with its own `sys.argv`. Made by
    Graph.run.
    """

    def __init__(self, main: Callable[..., Any], arguments: Sequence[str]) -> None:
        self.name = getattr(main, '__qualname__', repr(main))
        self._main = main
        self._result: object = None
        self._error: BaseException | None = None
        self._stopped = self._looked_at = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[Any] | None = None
        self._argv, sys.argv = sys.argv, [self.name, *arguments]
        self._thread = threading.Thread(target=self._run, name=f'program {self.name}', daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            if inspect.iscoroutinefunction(self._main):
                self._result = asyncio.run(self._follow(self._main()))
            else:
                self._result = self._main()
        except SystemExit as error:
            self._result = error.code
        except (asyncio.CancelledError, KeyboardInterrupt):
            self._result = None
        except BaseException as error:
            # The program's context was shut down while it ran, as when a signal stops a program.
            if not (self._stopped and isinstance(error, (ExternalShutdownException, RCLError))):
                self._error = error

    async def _follow(self, coroutine: Coroutine[Any, Any, object]) -> object:
        self._loop, self._task = asyncio.get_running_loop(), asyncio.current_task()
        return await coroutine

    @property
    def running(self) -> bool:
        """True if the program still runs."""
        return self._thread.is_alive()

    def wait(self, *, timeout: float = PATIENCE) -> object:
        """Wait for the program's end; return main's result or exit code; raise the error that main raised.

        Raises AssertionError after `timeout` s.
        """
        self._thread.join(timeout)
        if self._thread.is_alive():
            raise AssertionError(f"program '{self.name}' did not end within {timeout:g} s")
        self._looked_at = True
        if self._error is not None:
            raise self._error
        return self._result

    @property
    def unseen_error(self) -> BaseException | None:
        """The error that the program raised, unless `wait` has raised it already."""
        return None if self._looked_at else self._error

    def close(self) -> bool:
        """Wait for the program's end, after the end of its context; return False if it does not end."""
        self._thread.join(PATIENCE)
        sys.argv = self._argv
        return not self._thread.is_alive()

    def stop(self) -> None:
        """Cancel the program, if it is a coroutine. From now on the errors that the end of its context raises
        in the program are ignored.
        """
        self._stopped = True
        if self._loop is not None and self._task is not None and not self._loop.is_closed():
            try:
                self._loop.call_soon_threadsafe(self._task.cancel)
            except RuntimeError:
                return  # the program's loop was closed meanwhile
