"""launch_testing.event_handlers: starts actions when a process prints that it is ready."""

from __future__ import annotations

from typing import Any

from launch.actions import ExecuteProcess
from launch.event_handlers import OnProcessIO
from launch.events.process import ProcessIO

__all__ = ['StdoutReadyListener']


class StdoutReadyListener(OnProcessIO):
    """Carries out actions when a process prints a text."""

    def __init__(
        self, *, target_action: ExecuteProcess | None = None, ready_txt: str, actions: list[Any]
    ) -> None:
        def listen(process_io: ProcessIO) -> list[Any] | None:
            return actions if ready_txt in process_io.text.decode(errors='replace') else None

        super().__init__(target_action=target_action, on_stdout=listen)
        self._actions = actions

    def describe(self) -> tuple[str, list[Any]]:
        """Return a description of the handler: the awaited output, and the actions."""
        return super().describe()[0], self._actions
