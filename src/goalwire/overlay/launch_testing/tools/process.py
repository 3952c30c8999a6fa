"""launch_testing.tools.process: starts a process from a test while the launch runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from launch import LaunchDescription, LaunchService
from launch.actions import ExecuteProcess
from launch.events import IncludeLaunchDescription, matches_action
from launch.events.process import ProcessExited, ProcessStarted, ShutdownProcess
from launch.utilities import ensure_argument_type

from launch_testing.io_handler import ActiveIoHandler
from launch_testing.proc_info_handler import ActiveProcInfoHandler


class WaitedOutput:
    """Is true if the awaited output came. Its repr shows the output, so that a failed assertion does, too."""

    def __init__(self, has_come: bool, output: str | None) -> None:
        self._has_come = has_come
        self._output = output

    def __bool__(self) -> bool:
        return self._has_come

    def __repr__(self) -> str:
        return f'<{self._has_come}: {self._output!r}>'


class ProcessProxy:
    """The output and exit code of one process, and methods to wait for them."""

    def __init__(
        self,
        process_action: ExecuteProcess,
        proc_info: ActiveProcInfoHandler,
        proc_output: ActiveIoHandler,
        *,
        output_filter: Callable[[str], str] | None = None,
    ) -> None:
        """Observe a process. Raises TypeError if an argument has a wrong type."""
        ensure_argument_type(process_action, ExecuteProcess, 'process_action')
        ensure_argument_type(proc_info, ActiveProcInfoHandler, 'proc_info')
        ensure_argument_type(proc_output, ActiveIoHandler, 'proc_output')
        if output_filter is not None and not callable(output_filter):
            raise TypeError(f"Expected 'output_filter' to be callable but got '{output_filter!r}'")
        self._process_action = process_action
        self._proc_info = proc_info
        self._proc_output = proc_output
        self._filter = output_filter

    def wait_for_shutdown(self, timeout: float | None = None) -> bool:
        """Wait until the process has ended; return False after `timeout` s."""
        with self._proc_info.proc_event:
            return self._proc_info.proc_event.wait_for(lambda: self.terminated, timeout)

    def wait_for_output(
        self, condition: Callable[[str], bool] | None = None, timeout: float | None = None
    ) -> WaitedOutput:
        """Wait until the process runs and its output meets a condition.

        The result is true unless `timeout` s passed.
        """
        if condition is not None and not callable(condition):
            raise TypeError(f"Expected 'condition' to be callable but got '{condition!r}'")
        output: str | None = None

        def is_met() -> bool:
            nonlocal output
            if not self.running:
                return False
            output = self.output
            return condition is None or bool(condition(output))

        with self._proc_output.io_event:
            return WaitedOutput(self._proc_output.io_event.wait_for(is_met, timeout), output)

    @property
    def target_process_action(self) -> ExecuteProcess:
        return self._process_action

    @property
    def stderr(self) -> str:
        return self._text(lambda io: bool(io.from_stderr))

    @property
    def stdout(self) -> str:
        return self._text(lambda io: bool(io.from_stdout))

    @property
    def output(self) -> str:
        return self._text(lambda _: True)

    @property
    def running(self) -> bool:
        return isinstance(self._info(), ProcessStarted)

    @property
    def terminated(self) -> bool:
        return isinstance(self._info(), ProcessExited)

    @property
    def exit_code(self) -> int:
        return int(self._proc_info[self._process_action].returncode)

    def _info(self) -> Any:
        known = self._process_action in self._proc_info.processes()
        return self._proc_info[self._process_action] if known else None

    def _text(self, is_meant: Callable[[Any], bool]) -> str:
        data = b''.join(io.text for io in self._proc_output[self._process_action] if is_meant(io))
        text = data.decode(errors='replace')
        return text if self._filter is None else self._filter(text)


@contextmanager
def launch_process(
    launch_service: LaunchService,
    process_action: ExecuteProcess,
    proc_info: ActiveProcInfoHandler,
    proc_output: ActiveIoHandler,
    **kwargs: Any,
) -> Iterator[ProcessProxy]:
    """Start a process within a running launch, and shut it down at the end of the block."""
    proxy = ProcessProxy(process_action, proc_info, proc_output, **kwargs)
    launch_service.emit_event(IncludeLaunchDescription(LaunchDescription([process_action])))
    try:
        yield proxy
    finally:
        if not proxy.terminated:
            launch_service.emit_event(ShutdownProcess(process_matcher=matches_action(process_action)))
