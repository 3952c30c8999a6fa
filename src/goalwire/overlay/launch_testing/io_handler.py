"""launch_testing.io_handler: records the output of processes."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

from launch.actions import ExecuteLocal
from launch.events.process import ProcessIO

from launch_testing.asserts import assertInStream
from launch_testing.util import NoMatchingProcessException, ProcessChoice, resolveProcesses

__all__ = ['ActiveIoHandler', 'IoHandler']


class IoHandler:
    """Records the output of all processes, in the order in which it came."""

    def __init__(self) -> None:
        self._all: list[ProcessIO] = []
        self._by_process: dict[str, list[ProcessIO]] = {}

    def track(self, process_name: str) -> None:
        """Note that a process has been started."""
        self._by_process.setdefault(process_name, [])

    def append(self, process_io: ProcessIO) -> None:
        """Add a piece of output of a process."""
        self._all.append(process_io)
        self._by_process.setdefault(process_io.process_name, []).append(process_io)

    def __iter__(self) -> Iterator[ProcessIO]:
        return iter(self._all)

    def processes(self) -> list[ExecuteLocal]:
        """Return the actions of all processes that printed something."""
        found: list[Any] = [printed[0].action for printed in self._by_process.values() if printed]
        return found

    def process_names(self) -> list[str]:
        """Return the names of all processes that were started."""
        return list(self._by_process)

    def __getitem__(self, key: str | ExecuteLocal) -> list[ProcessIO]:
        name = key if isinstance(key, str) else str((key.process_details or {})['name'])
        return list(self._by_process[name])


class ActiveIoHandler:
    """Records the output of running processes. Any thread may wait for output."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._io_handler = IoHandler()

    @property
    def io_event(self) -> threading.Condition:
        """A threading.Condition that is notified of each output, and locked while output is added."""
        return self._changed

    def track(self, process_name: str) -> None:
        with self._changed:
            self._io_handler.track(process_name)
            self._changed.notify_all()

    def append(self, process_io: ProcessIO) -> None:
        with self._changed:
            self._io_handler.append(process_io)
            self._changed.notify_all()

    def __iter__(self) -> Iterator[ProcessIO]:
        with self._changed:
            return iter(list(self._io_handler))

    def processes(self) -> list[ExecuteLocal]:
        with self._changed:
            return self._io_handler.processes()

    def process_names(self) -> list[str]:
        with self._changed:
            return self._io_handler.process_names()

    def __getitem__(self, key: str | ExecuteLocal) -> list[ProcessIO]:
        with self._changed:
            return self._io_handler[key]

    def assertWaitFor(self, *args: Any, **kwargs: Any) -> None:
        """Do what `waitFor` does; raises AssertionError if the output does not come in time."""
        if not self.waitFor(*args, **kwargs):
            raise AssertionError('Waiting for output timed out')

    def waitFor(
        self,
        expected_output: Any,
        process: ProcessChoice = None,
        cmd_args: Any = None,
        *,
        strict_proc_matching: bool = True,
        output_filter: Any = None,
        timeout: float | None = 10,
        strip_ansi_escape_sequences: bool = True,
        stream: str = 'stderr',
    ) -> bool:
        """Wait until a process has printed the expected output; return False after `timeout` s."""

        def has_come() -> bool:
            try:
                assertInStream(
                    self._io_handler,
                    expected_output,
                    process,
                    cmd_args,
                    output_filter=output_filter,
                    strict_proc_matching=strict_proc_matching,
                    strip_ansi_escape_sequences=strip_ansi_escape_sequences,
                    stream=stream,
                )
            except (AssertionError, NoMatchingProcessException):
                return False
            return True

        with self._changed:
            if self._changed.wait_for(has_come, timeout):
                return True
        resolveProcesses(self, process=process, cmd_args=cmd_args, strict_proc_matching=False)
        return False
