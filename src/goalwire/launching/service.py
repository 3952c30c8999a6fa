"""The loop that carries launch descriptions out."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import threading
import time
import traceback
from collections.abc import Coroutine, Iterable, Iterator
from typing import Any

from goalwire.errors import LaunchError
from goalwire.launching.errors import locate
from goalwire.launching.event_handlers import OnIncludeLaunchDescription
from goalwire.launching.events import IncludeLaunchDescription, Shutdown, SignalProcess
from goalwire.launching.model import (
    Event,
    LaunchContext,
    LaunchDescription,
    entity_list,
    visit_tree,
)
from goalwire.launching.output import get_logger, launch_config, log_launch_config

SAME_S = 0.5
"""Signals within so many s count as one signal: wrappers such as `uv run` repeat the terminal's signals."""


class LaunchService:
    """Carries out launch descriptions until everything that they started has ended."""

    def __init__(
        self, *, argv: Iterable[str] | None = None, debug: bool = False, noninteractive: bool = False
    ) -> None:
        if debug:
            import logging

            launch_config.level = logging.DEBUG
        self._debug = debug
        self._logger = get_logger('launch')
        log_launch_config(self._logger)
        self._context = LaunchContext(argv=argv, noninteractive=noninteractive)
        self._context.on_failure = self._fail
        self._context.register_event_handler(OnIncludeLaunchDescription())
        self._lock = threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[int] | None = None
        self._futures: set[asyncio.Future[Any]] = set()
        self._news: asyncio.Event | None = None
        self._shutting_down = False
        self._interrupts = 0
        self._interrupted_at = -SAME_S
        self._return_code = 0
        self._errors: list[Exception] = []
        self.interrupted_by: signal.Signals | None = None
        """The signal that ended the launch; None if no signal has ended it."""

    @property
    def context(self) -> LaunchContext:
        return self._context

    @property
    def event_loop(self) -> asyncio.AbstractEventLoop | None:
        return self._loop

    @property
    def task(self) -> asyncio.Task[int] | None:
        return self._task

    def emit_event(self, event: Event) -> None:
        """Queue an event. Any thread may call this method. Events queued before run() wait for run()."""
        with self._lock:
            if self._loop is not None:
                self._loop.call_soon_threadsafe(self._context.emit_event_sync, event)
            else:
                self._context.events.append(event)

    def include_launch_description(self, launch_description: LaunchDescription) -> None:
        """Carry out another description in this launch. Any thread may call this method."""
        self.emit_event(IncludeLaunchDescription(launch_description))

    def shutdown(self, force_sync: bool = False) -> Coroutine[None, None, None] | None:
        """Shut the launch down; do nothing if the service does not run. Any thread may call this method.

        As in launch, a call in the service's own loop returns a coroutine that waits for the launch's end,
        unless `force_sync` is set.
        """
        with self._lock:
            if self._loop is None:
                return None
            self._loop.call_soon_threadsafe(self._shut_down, 'LaunchService.shutdown() called')
            inside = _running_loop() is self._loop
        return self._until_done() if inside and not force_sync else None

    async def _until_done(self) -> None:
        if self._task is not None and self._task is not asyncio.current_task():
            await asyncio.wait([self._task])

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Carry out the included descriptions. Return 1 after a failure, else 0.

        In the main thread, Ctrl-C, SIGTERM and SIGHUP shut the launch down in order. Raises LaunchError if
        the service runs already.
        """
        return asyncio.run(self.run_async(shutdown_when_idle=shutdown_when_idle), debug=self._debug)

    async def run_async(self, *, shutdown_when_idle: bool = True) -> int:
        """Do the same as run(), but in the asyncio loop that already runs."""
        with self._lock:
            if self._loop is not None:
                raise LaunchError('this LaunchService runs already')
            self._loop = asyncio.get_running_loop()
            self._task = asyncio.current_task()
        self._news = asyncio.Event()
        self._return_code = 0
        self._interrupts, self._interrupted_at = 0, -SAME_S
        self.interrupted_by = None
        self._shutting_down = False
        self._context.is_shutdown = self._context.is_aborted = False
        self._context.attach(self._loop, self._news.set)
        launch_config.screen_handler.on_closed = self._on_screen_closed
        try:
            with self._signals():
                try:
                    return await self._work(shutdown_when_idle=shutdown_when_idle)
                finally:
                    while self._context.async_cleanups:
                        await self._context.async_cleanups.pop()()
        finally:
            self._tell_errors()
            launch_config.screen_handler.on_closed = lambda: None
            with self._lock:
                self._loop = None
            self._context.attach(None, lambda: None)
            while self._context.cleanups:
                self._context.cleanups.pop()()

    async def _work(self, *, shutdown_when_idle: bool) -> int:
        """Handle events until there is nothing left to wait for; return the exit code."""
        try:
            while True:
                await self._handle_events()
                idle = not self._futures and not self._context.completion_futures
                if idle and not self._context.events:
                    if self._shutting_down:
                        break
                    if shutdown_when_idle:
                        self._shut_down('idle')
                        continue
                if self._news is not None and not self._context.events:
                    await self._news.wait()
        except asyncio.CancelledError:
            await self._end_after_cancel()
            raise
        if self._context.get_locals_as_dict().get('launch_failed'):
            return 1
        return self._return_code

    async def _end_after_cancel(self) -> None:
        """End the launch's processes after the program has cancelled the task of run_async()."""
        self._shut_down('the task of LaunchService.run_async() was cancelled')
        while self._futures or self._context.completion_futures or self._context.events:
            await self._handle_events()
            if self._news is not None and (self._futures or self._context.completion_futures):
                await self._news.wait()

    async def _handle_events(self) -> None:
        if self._news is not None:
            self._news.clear()
        while self._context.events:
            event = self._context.events.popleft()
            if isinstance(event, Shutdown):
                self._shutting_down = True
                self._context.is_shutdown = True
            for handler in tuple(self._context.handlers):
                self._handle(handler, event)
            if not self._context.events:
                await asyncio.sleep(0)  # let new tasks start before _work() decides that the launch is idle

    def _handle(self, handler: Any, event: Event) -> None:
        self._context.push_locals()
        try:
            if handler.matches(event):
                for entity in entity_list(handler.handle(event, self._context)):
                    for _, future in visit_tree(entity, self._context):
                        self._wait_for(future)
        except Exception as error:
            self._fail(error)
        finally:
            self._context.pop_locals()

    def _wait_for(self, future: asyncio.Future[Any]) -> None:
        if not future.done():
            self._futures.add(future)
        future.add_done_callback(self._on_end)

    def _on_end(self, future: asyncio.Future[Any]) -> None:
        self._futures.discard(future)
        if not future.cancelled() and (error := future.exception()) is not None:
            self._fail(error if isinstance(error, Exception) else RuntimeError(str(error)))
        if self._news is not None:
            self._news.set()

    def _fail(self, error: Exception) -> None:
        """Shut the launch down because of an error, which is logged after the processes' last lines."""
        self._errors.append(error)
        self._return_code = 1
        self._context.is_aborted = True
        if self._context.running_processes and not self._shutting_down:
            self._logger.warning('ending the running processes because of the error below')
        self._shut_down(f'an error: {locate(error, None)}')

    def _tell_errors(self) -> None:
        for error in self._errors:
            self._logger.debug(''.join(traceback.format_exception(error)))
        for text in dict.fromkeys(str(locate(error, None)) for error in self._errors):
            self._logger.error(text)
        self._errors.clear()

    def _shut_down(self, reason: str, *, due_to_sigint: bool = False) -> None:
        if self._shutting_down:
            return
        self._shutting_down = True
        self._context.is_shutdown = True
        self._context.emit_event_sync(Shutdown(reason=reason, due_to_sigint=due_to_sigint))

    # --- signals

    @contextlib.contextmanager
    def _signals(self) -> Iterator[None]:
        """Let signals shut the launch down in order, if this is the main thread."""
        if threading.current_thread() is not threading.main_thread() or self._loop is None:
            yield
            return
        before: dict[signal.Signals, Any] = {}
        loop = self._loop
        for name in ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGQUIT'):
            number = getattr(signal, name, None)
            if number is None or (name == 'SIGHUP' and signal.getsignal(number) is signal.SIG_IGN):
                continue  # nohup ignores SIGHUP, so the launch does, too
            with contextlib.suppress(NotImplementedError, ValueError, RuntimeError):
                before[number] = signal.getsignal(number)
                loop.add_signal_handler(number, self._on_interrupt, number)
        try:
            yield
        finally:
            for number, handler in before.items():
                with contextlib.suppress(NotImplementedError, ValueError, RuntimeError, TypeError):
                    loop.remove_signal_handler(number)
                    signal.signal(number, handler)

    def _on_interrupt(self, number: signal.Signals) -> None:
        """On the first signal end all processes, on the second send them SIGTERM, on the third SIGKILL."""
        now = time.monotonic()
        if now - self._interrupted_at < SAME_S:
            return
        self._interrupts, self._interrupted_at = self._interrupts + 1, now
        what = (
            'user interrupted with ctrl-c (SIGINT)'
            if number == signal.SIGINT
            else f'received {signal.Signals(number).name}'
        )
        if self._interrupts == 1:
            self.interrupted_by = number
            self._logger.warning(what)
            self._shut_down(what, due_to_sigint=number == signal.SIGINT)
            return
        harder = 'SIGTERM' if self._interrupts == 2 or os.name != 'posix' else 'SIGKILL'
        self._logger.warning(f"{what} again, sending '{harder}' to what is left")
        self._context.emit_event_sync(
            SignalProcess(
                signal_number=harder,
                process_matcher=lambda action: bool((action.process_details or {}).get('pid')),
            )
        )

    def _on_screen_closed(self) -> None:
        """Shut the launch down, since nobody reads its output any more, as in `ros2 launch … | head`."""
        if self._loop is not None:
            self._shut_down('standard output was closed')


def _running_loop() -> asyncio.AbstractEventLoop | None:
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None
