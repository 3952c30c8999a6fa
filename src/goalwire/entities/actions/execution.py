"""One run of an execute callback, and what becomes of what it returns."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import TYPE_CHECKING, Any, NamedTuple

from goalwire.entities.enclosing import Enclosing
from goalwire.errors import ShutDownError, peer_text
from goalwire.execution.callback_source import CallbackSource
from goalwire.rules.goals import wire
from goalwire.rules.goals.table import GoalStatus

if TYPE_CHECKING:
    from goalwire.entities.actions.goal_handle import ServerGoalHandle
    from goalwire.entities.actions.server import ActionServerCore
    from goalwire.entities.type_support import ActionSupport
    from goalwire.logging import RcutilsLogger


class Failure(NamedTuple):
    """What an execute callback came to that did not return a result."""

    result: object = None
    """What is sent along; None: a result of default values."""
    reason: str = ''
    """What clients that know goalwire are told."""


class Execution(CallbackSource):
    """Runs an execute callback, in no callback group, as in rclpy."""

    __slots__ = ('_begun', '_callback', '_handle', '_server')

    def __init__(
        self, server: ActionServerCore, handle: ServerGoalHandle, callback: Callable[[ServerGoalHandle], Any]
    ) -> None:
        super().__init__(server.node.work_queue, None)
        self._server = server
        self._handle = handle
        self._callback = callback
        self._begun = 0

    def run(self) -> object:
        if self._server.destroyed:
            return None
        self._begun = self._server.steady_clock.now()
        try:
            result = self._callback(self._handle)
        except BaseException as error:
            self._failed(error)
            return None
        if isinstance(result, CoroutineType):
            return Enclosing(self._carry(result), [result])
        self._finish(result)
        return None

    async def _carry(self, coroutine: Coroutine[Any, Any, Any]) -> None:
        from asyncio import CancelledError

        try:
            result = await coroutine
        except CancelledError:  # the executor was shut down
            self._finish(Failure())
            raise
        except BaseException as error:
            self._failed(error)
        else:
            self._finish(result)

    def _finish(self, outcome: object) -> None:
        self._server.durations.add(self._server.steady_clock.now() - self._begun)
        self._server.finished(self._handle, outcome)

    def _failed(self, error: BaseException) -> None:
        if isinstance(error, ShutDownError) and not self._server.node.context.ok():
            self._server.logger.warning(f'A goal was stopped by the end of the context: {error}')
        else:
            self._log(error)
        if isinstance(error, Exception):
            self._finish(self._server.failure(self._handle, error))
        else:
            self._finish(Failure())
            raise error

    def _log(self, error: BaseException) -> None:
        from goalwire.logging.tracebacks import traceback_text

        told = f'Error raised in execute callback: {peer_text(error)}'
        self._server.logger.error(f'{told}\n{traceback_text(error)}')


class Results:
    """Makes GetResult responses. Their status is only known when they are sent: see wire.with_status."""

    def __init__(self, support: ActionSupport, name: str, logger: RcutilsLogger) -> None:
        self._support = support.get_result
        self._class = support.cls.Result  # type: ignore[attr-defined]
        self._name = name
        self._logger = logger

    def encode(self, outcome: object) -> bytes | None:
        """Serialize what an execute callback returned, or came to.

        None, which stands for the default, once that is logged, where it cannot be sent.
        """
        if not isinstance(outcome, Failure):
            return self._encode_result(outcome, 'the execute callback returned')
        given = outcome.result
        result = None if given is None else self._encode_result(given, 'the failure came with')
        return wire.with_reason(result or self.default(), outcome.reason) if outcome.reason else result

    def _encode_result(self, result: object, told: str) -> bytes | None:
        if not isinstance(result, self._class):
            self._logger.error(
                f"Action '{self._name}': {told} {type(result).__name__}; "
                f'an empty result is sent; return a {self._class.__name__}'
            )
            return None
        try:
            return self._encode(result)
        except (TypeError, ValueError) as error:
            self._logger.error(f'Result cannot be sent, an empty one is: {error}')
            return None

    def default(self) -> bytes:
        """Serialize the result of a goal that has none."""
        return self._encode(self._class())

    def _encode(self, result: object) -> bytes:
        response: Any = self._support.response
        return self._support.encode_response(response(status=int(GoalStatus.UNKNOWN), result=result))
