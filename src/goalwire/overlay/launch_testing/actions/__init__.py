"""launch_testing.actions: ReadyToTest."""

from __future__ import annotations

from collections.abc import Callable

from launch import Action, LaunchContext

__all__ = ['ReadyToTest']


class ReadyToTest(Action):
    """Tells the test runner that the tests can begin."""

    def __init__(self) -> None:
        super().__init__()
        self._callbacks: list[Callable[[], object]] = []

    def _add_callback(self, callback: Callable[[], object]) -> None:
        self._callbacks.append(callback)

    def execute(self, context: LaunchContext) -> None:
        """Tell the test runner that the launch is ready."""
        for callback in self._callbacks:
            callback()
