"""Event handlers for the start, the output and the end of processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from goalwire.launching.event_handlers import Answer, OnActionEventBase, Target
from goalwire.launching.events import ProcessExited, ProcessIO, ProcessStarted
from goalwire.launching.model import LaunchContext, SomeEntities
from goalwire.launching.process import ExecuteLocal


class OnProcessStart(OnActionEventBase):
    """Handles the start of a process."""

    def __init__(self, *, target_action: Target = None, on_start: Answer = None, **options: Any) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_start,
            target_event_cls=ProcessStarted,
            target_action_cls=ExecuteLocal,
            **options,
        )


class OnProcessExit(OnActionEventBase):
    """Handles the end of a process."""

    def __init__(self, *, target_action: Target = None, on_exit: Answer = None, **options: Any) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_exit,
            target_event_cls=ProcessExited,
            target_action_cls=ExecuteLocal,
            **options,
        )


class OnProcessIO(OnActionEventBase):
    """Handles the output of a process."""

    def __init__(
        self,
        *,
        target_action: Target = None,
        on_stdin: Callable[[ProcessIO], SomeEntities | None] | None = None,
        on_stdout: Callable[[ProcessIO], SomeEntities | None] | None = None,
        on_stderr: Callable[[ProcessIO], SomeEntities | None] | None = None,
        **options: Any,
    ) -> None:
        self._by_fd = {0: on_stdin, 1: on_stdout, 2: on_stderr}
        super().__init__(
            action_matcher=target_action,
            on_event=self._io,
            target_event_cls=ProcessIO,
            target_action_cls=ExecuteLocal,
            **options,
        )

    def _io(self, event: ProcessIO, context: LaunchContext) -> SomeEntities | None:
        answer = self._by_fd.get(event.fd)
        return None if answer is None else answer(event)
