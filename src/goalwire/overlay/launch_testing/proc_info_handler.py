"""launch_testing.proc_info_handler: records which processes run, and the exit codes of those that ended."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from launch.actions import ExecuteLocal
from launch.events.process import ProcessExited, ProcessStarted

from launch_testing.util import NoMatchingProcessException, ProcessChoice, resolveProcesses

__all__ = ['ActiveProcInfoHandler', 'ProcInfoHandler']

ProcessInfo: TypeAlias = ProcessStarted | ProcessExited


class ProcInfoHandler:
    """The last event of each process: its start, or its end with the exit code."""

    def __init__(self) -> None:
        self._last: dict[Any, ProcessInfo] = {}

    def append(self, process_info: ProcessInfo) -> None:
        """Note that a process has started, or has ended."""
        self._last[process_info.action] = process_info

    def __iter__(self) -> Iterator[ProcessInfo]:
        return iter(list(self._last.values()))

    def processes(self) -> list[ExecuteLocal]:
        """Return the actions of all processes that were started."""
        return list(self._last)

    def process_names(self) -> list[str]:
        """Return the names of all processes that were started."""
        return [info.process_name for info in self._last.values()]

    def __getitem__(self, key: str | ExecuteLocal) -> Any:
        if not isinstance(key, str):
            return self._last[key]
        for info in self._last.values():
            if key in info.process_name:
                return info
        raise KeyError(key)


class ActiveProcInfoHandler:
    """Records starts and ends of processes while the launch runs. Any thread may wait for such an event."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._proc_info_handler = ProcInfoHandler()

    @property
    def proc_event(self) -> threading.Condition:
        """A threading.Condition that is notified when a process has started or ended."""
        return self._changed

    def append(self, process_info: ProcessInfo) -> None:
        with self._changed:
            self._proc_info_handler.append(process_info)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[ProcessInfo]:
        with self._changed:
            return iter(self._proc_info_handler)

    def processes(self) -> list[ExecuteLocal]:
        with self._changed:
            return self._proc_info_handler.processes()

    def process_names(self) -> list[str]:
        with self._changed:
            return self._proc_info_handler.process_names()

    def __getitem__(self, key: str | ExecuteLocal) -> Any:
        with self._changed:
            return self._proc_info_handler[key]

    def assertWaitForStartup(
        self, process: ProcessChoice, cmd_args: Any = None, *, timeout: float | None = 10
    ) -> None:
        """Wait until a process has started. Raises AssertionError if that takes longer than `timeout` s."""
        if not self._wait(process, cmd_args, lambda _: True, timeout):
            raise AssertionError(f"Timed out waiting for process '{process}' to start")

    def assertWaitForShutdown(
        self, process: ProcessChoice, cmd_args: Any = None, *, timeout: float | None = 10
    ) -> None:
        """Wait until a process has ended. Raises AssertionError if that takes longer than `timeout` s."""
        if not self._wait(process, cmd_args, lambda info: isinstance(info, ProcessExited), timeout):
            raise AssertionError(f"Timed out waiting for process '{process}' to finish")

    def _wait(
        self,
        process: ProcessChoice,
        cmd_args: Any,
        is_met: Callable[[ProcessInfo], bool],
        timeout: float | None,
    ) -> bool:
        infos = self._proc_info_handler

        def is_known_and_met() -> bool:
            try:
                return is_met(infos[resolveProcesses(infos, process=process, cmd_args=cmd_args)[0]])
            except NoMatchingProcessException:
                return False

        with self._changed:
            return self._changed.wait_for(is_known_and_met, timeout)
