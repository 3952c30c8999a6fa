"""Actions that run a process: they start, watch, respawn and end it."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import shlex
import signal
from collections.abc import Callable, Iterable, Mapping
from itertools import count
from typing import Any, TypeAlias

from goalwire.errors import LaunchError
from goalwire.launching.child_process import Child, start_child
from goalwire.launching.errors import locate
from goalwire.launching.event_handlers import Answer, OnActionEventBase
from goalwire.launching.events import (
    ProcessExited,
    ProcessStarted,
    ProcessStderr,
    ProcessStdout,
    Shutdown,
    ShutdownProcess,
    SignalProcess,
)
from goalwire.launching.model import (
    Action,
    Event,
    EventHandler,
    LaunchContext,
    LaunchDescriptionEntity,
    SomeEntities,
    SomeSubstitutions,
    Substitution,
)
from goalwire.launching.output import get_logger, get_output_loggers
from goalwire.launching.output_lines import Lines
from goalwire.launching.substitutions import LaunchConfiguration
from goalwire.launching.values import (
    TextSubstitution,
    evaluate_condition_expression,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    truth,
)

_numbers = count(1)
Variables: TypeAlias = Mapping[Any, SomeSubstitutions]
NormalizedVariables: TypeAlias = list[tuple[list[Substitution], list[Substitution]]]


class Executable:
    """A command, its working folder and its environment; `prepare` evaluates the substitutions in them."""

    def __init__(
        self,
        *,
        cmd: Iterable[SomeSubstitutions],
        prefix: SomeSubstitutions | None = None,
        name: SomeSubstitutions | None = None,
        cwd: SomeSubstitutions | None = None,
        env: Variables | None = None,
        additional_env: Variables | None = None,
        arguments: Iterable[SomeSubstitutions] | None = None,
    ) -> None:
        self.cmd = [normalize_to_list_of_substitutions(part) for part in (*cmd, *(arguments or ()))]
        if not self.cmd:
            raise LaunchError('a process needs a command: cmd is empty')
        self.prefix = normalize_to_list_of_substitutions(
            LaunchConfiguration('launch-prefix', default='') if prefix is None else prefix
        )
        self._has_own_prefix = prefix is not None
        self.name = None if name is None else normalize_to_list_of_substitutions(name)
        self.cwd = None if cwd is None else normalize_to_list_of_substitutions(cwd)
        self.env = None if env is None else _normalize_variables(env)
        self.additional_env = None if additional_env is None else _normalize_variables(additional_env)
        self.final_name: str | None = None
        self.final_cmd: list[str] | None = None
        self.final_cwd: str | None = None
        self.final_env: dict[str, str] | None = None

    def prepare(self, context: LaunchContext, action: ExecuteLocal | None = None) -> None:
        """Evaluate command, name, folder and environment into the `final_…` attributes."""
        cmd = action.command(context) if action is not None else self.command(context)
        wanted = '' if self._has_own_prefix else context.launch_configurations.get('launch-prefix-filter', '')
        if re.match(str(wanted), os.path.basename(cmd[0])):
            cmd = shlex.split(perform_substitutions(context, self.prefix)) + cmd
        if self.name is not None:
            name = perform_substitutions(context, self.name)
        else:  # with `shell`, the command line is one text, whose first word is the program
            is_line = action is not None and action.shell
            name = os.path.basename(cmd[0].split(maxsplit=1)[0] if is_line and cmd[0].strip() else cmd[0])
        self.final_name = f'{name}-{next(_numbers)}'
        self.final_cmd = cmd
        self.final_cwd = None if self.cwd is None else perform_substitutions(context, self.cwd)
        env = dict(context.environment) if self.env is None else _perform_variables(context, self.env)
        self.final_env = env | _perform_variables(context, self.additional_env or [])

    def command(self, context: LaunchContext) -> list[str]:
        return [perform_substitutions(context, part) for part in self.cmd]


def _normalize_variables(variables: Variables) -> NormalizedVariables:
    return [
        (normalize_to_list_of_substitutions(name), normalize_to_list_of_substitutions(value))
        for name, value in variables.items()
    ]


def _perform_variables(context: LaunchContext, variables: NormalizedVariables) -> dict[str, str]:
    return {
        perform_substitutions(context, name): perform_substitutions(context, value)
        for name, value in variables
    }


class ExecuteLocal(Action):
    """Runs a process on this machine."""

    def __init__(
        self,
        *,
        process_description: Executable,
        shell: bool = False,
        sigterm_timeout: SomeSubstitutions | float | None = None,
        sigkill_timeout: SomeSubstitutions | float | None = None,
        emulate_tty: bool = False,
        output: SomeSubstitutions | dict[str, Any] = 'log',
        output_format: str = '[{this.process_description.final_name}] {line}',
        cached_output: bool = False,
        log_cmd: bool = False,
        on_exit: Answer = None,
        respawn: bool | SomeSubstitutions = False,
        respawn_delay: float | None = None,
        respawn_max_retries: int = -1,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self.process_description = process_description
        self.shell = shell
        self.emulate_tty = emulate_tty
        self._timeouts = (
            _timeout('sigterm_timeout', sigterm_timeout),
            _timeout('sigkill_timeout', sigkill_timeout),
        )
        forced = os.environ.get('OVERRIDE_LAUNCH_PROCESS_OUTPUT')
        self._output = forced or output
        self._output_format = output_format
        self._cached_output = cached_output
        self._log_cmd = log_cmd
        self._on_exit = on_exit
        self._respawn = respawn
        self._respawn_delay = respawn_delay
        self._respawns_left = respawn_max_retries
        self._child: Child | None = None
        self._details: dict[str, Any] | None = None
        self._completed: asyncio.Future[None] | None = None
        self._stopping: asyncio.Event | None = None
        self._ending: asyncio.Task[None] | None = None
        self._stdout: Lines | None = None
        self._stderr: Lines | None = None

    # --- read by users

    @property
    def output(self) -> SomeSubstitutions | dict[str, Any]:
        return self._output

    @property
    def sigterm_timeout(self) -> list[Substitution]:
        return self._timeouts[0]

    @property
    def sigkill_timeout(self) -> list[Substitution]:
        return self._timeouts[1]

    @property
    def process_details(self) -> dict[str, Any] | None:
        """Name, command, folder, environment and, once it runs, pid of the process; None before execution."""
        return self._details

    @property
    def return_code(self) -> int | None:
        """The exit code; None until the process has ended."""
        return None if self._child is None else self._child.returncode

    def get_stdout(self) -> str:
        """Return the process's output so far. Raises LaunchError without `cached_output`."""
        return self._cache(self._stdout, 'stdout')

    def get_stderr(self) -> str:
        """Return the process's standard error so far. Raises LaunchError without `cached_output`."""
        return self._cache(self._stderr, 'stderr')

    def _cache(self, lines: Lines | None, stream: str) -> str:
        if not self._cached_output:
            raise LaunchError(f'get_{stream}() needs cached_output=True')
        return (lines.text if lines else None) or ''

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return list(self._on_exit) if isinstance(self._on_exit, list) else []

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return []

    def get_asyncio_future(self) -> asyncio.Future[None] | None:
        return self._completed

    # --- starting

    def command(self, context: LaunchContext) -> list[str]:
        """Return the evaluated command, without its prefix."""
        return self.process_description.command(context)

    def execute(self, context: LaunchContext) -> Any:
        if context.is_shutdown:
            return
        if self._completed is not None:
            raise LaunchError(
                f'{self.describe()} is executed a second time: make one action for each process'
            )
        description = self.process_description
        description.prepare(context, self)
        name = description.final_name or ''
        self._details = {
            'action': self,
            'name': name,
            'cmd': description.final_cmd,
            'cwd': description.final_cwd,
            'env': description.final_env,
        }
        output = self._output
        if not isinstance(output, dict):
            output = perform_substitutions(context, normalize_to_list_of_substitutions(output))
        loggers = get_output_loggers(name, output)
        self._stdout, self._stderr = (self._lines(logger) for logger in loggers)
        respawn = self._respawn
        if not isinstance(respawn, bool):
            respawn = truth(context, respawn)
        handlers: list[EventHandler] = [
            _Answers(ShutdownProcess, self._on_shutdown_process),
            _Answers(SignalProcess, self._on_signal_process),
            _Answers(Shutdown, self._on_shutdown),
        ]
        if self._on_exit is not None:
            handlers.append(
                OnActionEventBase(action_matcher=self, on_event=self._on_exit, target_event_cls=ProcessExited)
            )
        for handler in handlers:
            context.register_event_handler(handler)
        self._completed = context.asyncio_loop.create_future()
        self._stopping = asyncio.Event()
        context.add_completion_future(context.asyncio_loop.create_task(self._run(context, respawn=respawn)))

    def _lines(self, logger: Any) -> Lines:
        def tell(line: str) -> None:
            text = self._output_format.format(line=line, this=self)
            logger.info('%s', text)

        return Lines(tell, cached=self._cached_output)

    def _emulates_tty(self, context: LaunchContext) -> bool:
        configured = context.launch_configurations.get('emulate_tty')
        if configured is None:
            return self.emulate_tty
        return evaluate_condition_expression(context, [TextSubstitution(text=str(configured))])

    async def _run(self, context: LaunchContext, *, respawn: bool) -> None:
        """Run the process; with `respawn` run it again whenever it ends, until the launch stops it."""
        try:
            while await self._run_once(context) and respawn and self._respawns_left != 0:
                if context.is_shutdown or self._stopping is None or self._stopping.is_set():
                    break
                self._respawns_left -= 1
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._stopping.wait(), self._respawn_delay or 0.0)
                if self._stopping.is_set():
                    break
        finally:
            if self._completed is not None and not self._completed.done():
                self._completed.set_result(None)

    async def _run_once(self, context: LaunchContext) -> bool:
        """Run the process to its end; return False if it could not be started."""
        if context.is_aborted:
            return False
        details = dict(self._details or {})
        name, cmd = details['name'], details['cmd']
        logger = get_logger(name)
        shown = ' '.join(part for part in cmd if part.strip())
        if self._log_cmd:
            custom = self.process_description.env is not None
            logger.info(f"process details: cmd='{shown}', cwd='{details['cwd']}', custom_env?={custom}")

        def on_output(_: Child, fd: int, data: bytes) -> None:
            event = ProcessStdout if fd == 1 else ProcessStderr
            lines = self._stdout if fd == 1 else self._stderr
            if lines is not None:
                lines.feed(data)
            context.emit_event_sync(event(text=data, **details))

        def on_start(child: Child) -> None:
            self._child = child
            details['pid'] = child.pid
            self._details = details
            context.running_processes += 1
            logger.info(f'process started with pid [{child.pid}]')
            context.emit_event_sync(ProcessStarted(**details))

        try:
            child = await start_child(
                cmd,
                cwd=details['cwd'],
                env=details['env'],
                shell=self.shell,
                emulate_tty=self._emulates_tty(context),
                on_start=on_start,
                on_output=on_output,
            )
        except (OSError, ValueError) as error:
            logger.error(str(locate(error, self.location, f"cannot start '{cmd[0]}': ")))
            context.extend_globals({'launch_failed': True})
            return False
        if self._stopping is not None and self._stopping.is_set():
            self._begin_ending(context)  # a shutdown was requested while the process was being started
        code = await child.wait_for_end()
        context.running_processes -= 1
        for lines in (self._stdout, self._stderr):
            if lines is not None:
                lines.flush()
        if code and self._stderr is not None and self._stderr.was_interrupted_early:
            logger.info(f'process was interrupted while it was still starting [pid {child.pid}]')
        elif code == 0:
            logger.info(f'process has finished cleanly [pid {child.pid}]')
        else:
            logger.error(f"process has died [pid {child.pid}, exit code {code}, cmd '{shown}'].")
        context.emit_event_sync(ProcessExited(returncode=code, **details))
        if self._ending is not None:
            await self._ending
        if not child.group_alive():
            child.close()
        return True

    # --- ending

    def _on_shutdown_process(self, event: ShutdownProcess, context: LaunchContext) -> None:
        if event.process_matcher(self):
            self._begin_ending(context)

    def _on_shutdown(self, event: Shutdown, context: LaunchContext) -> None:
        self._begin_ending(context)

    def _on_signal_process(self, event: SignalProcess, context: LaunchContext) -> None:
        if not event.process_matcher(self):
            return
        if self._child is None:
            raise LaunchError(f'cannot send {event.signal_name} to {self.describe()}: it has not started')
        self._signal(event.signal)

    def _signal(self, wanted: signal.Signals) -> None:
        child = self._child
        if child is not None and child.group_alive():
            get_logger(self._details['name'] if self._details else None).info(
                f"sending signal '{wanted.name}' to process[{self._details['name'] if self._details else ''}]"
            )
            child.signal(wanted)

    def _begin_ending(self, context: LaunchContext) -> None:
        """Start ending the process, once: SIGINT, then SIGTERM and SIGKILL if it still runs."""
        if self._stopping is not None:
            self._stopping.set()
        child = self._child
        if child is None or self._ending is not None or not child.group_alive():
            return
        seconds = [_seconds(context, text) for text in self._timeouts]
        if self._stdout is not None and self._stderr is not None and not self._stdout.has_begun:
            self._stderr.expect_interrupt()
        self._ending = context.asyncio_loop.create_task(self._end(child, seconds))
        context.add_completion_future(self._ending)

    async def _end(self, child: Child, seconds: list[float]) -> None:
        name = self._details['name'] if self._details else ''
        sent = signal.SIGINT
        self._signal(sent)
        for wait, following in zip(seconds, ('SIGTERM', 'SIGKILL'), strict=True):
            if await child.wait_for_group(wait):
                break
            get_logger(name).error(
                f"process[{name}] failed to terminate '{wait:g}' seconds after receiving '{sent.name}', "
                f"escalating to '{following}'"
            )
            sent = getattr(signal, following, signal.SIGTERM)
            self._signal(sent)
        else:
            await child.wait_for_group(1.0)
        if child.exited.done():
            child.close()


def _timeout(name: str, given: SomeSubstitutions | float | None) -> list[Substitution]:
    if given is None:
        return normalize_to_list_of_substitutions(LaunchConfiguration(name, default='5'))
    return normalize_to_list_of_substitutions(str(given) if isinstance(given, int | float) else given)


def _seconds(context: LaunchContext, text: list[Substitution]) -> float:
    try:
        return max(0.0, float(perform_substitutions(context, text)))
    except ValueError:
        return 5.0


class _Answers(EventHandler):
    """An event handler that calls a method with each event of one class."""

    def __init__(self, event_class: type[Any], method: Callable[[Any, LaunchContext], None]) -> None:
        super().__init__(matcher=lambda event: isinstance(event, event_class))
        self._method = method

    def handle(self, event: Event, context: LaunchContext) -> SomeEntities | None:
        self._method(event, context)
        return None
