"""The results of an action server's goals: how they are serialized, sent, and kept in a journal."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from goalwire.entities.message_type_errors import short_name
from goalwire.errors import ClosedError, TransportError
from goalwire.places import at, function_place
from goalwire.rules.goals import wire
from goalwire.rules.goals.journal import RESULT_DROPPED, SERVER_DIED, absence_text
from goalwire.rules.goals.states import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Callable

    from goalwire.entities.actions.journal_file import JournalFile
    from goalwire.entities.type_support import ActionSupport
    from goalwire.errors import JournalError
    from goalwire.execution.future import Future
    from goalwire.logging import RcutilsLogger
    from goalwire.rules.goals.effects import FindResult, KeepResult
    from goalwire.rules.goals.ids import GoalId
    from goalwire.rules.goals.journal import GoalJournal, KnownGoal
    from goalwire.transport.contract import Request


class ServerResults:
    """Serializes and sends results. With a journal, a result is on the disk before anybody gets it."""

    def __init__(
        self, name: str, support: ActionSupport, logger: RcutilsLogger, settings: GoalJournal | None
    ) -> None:
        """Open the journal. Raises JournalError."""
        self._name = name
        self._support = support
        self._result_class: type = support.cls.Result  # type: ignore[attr-defined]
        self._logger = logger
        self.journal: JournalFile | None = None
        """The journal; None if the server keeps none."""
        if settings is not None:
            # imported here: few servers need SQLite
            from goalwire.entities.actions.journal_file import JournalFile

            self.journal = JournalFile(settings)

    # -- serialized ----------------------------------------------------------------------------------------

    def encode(self, result: object, told: str, execute: Callable[..., object] | None) -> bytes | None:
        """Serialize a result. If it cannot be encoded, log that, and return None, which stands for the
        default.

        The goal's status is added when the result is sent: see wire.with_status.
        """
        if not isinstance(result, self._result_class):
            self._logger.error(
                f"Action '{self._name}': {told} {type(result).__name__}; an empty result is sent; "
                f"write 'return {short_name(self._result_class)}(…)'"
                f'{at(function_place(execute))}'
            )
            return None
        support = self._support.get_result
        response: Any = support.response
        try:
            return support.encode_response(response(status=int(GoalStatus.UNKNOWN), result=result))
        except (TypeError, ValueError) as error:
            self._logger.error(f'Result cannot be sent, an empty one was sent: {error}')
            return None

    def default(self) -> bytes:
        """Serialize the result of a goal that has none."""
        support = self._support.get_result
        return support.encode_response(support.response())

    def reply(
        self, request: Request, status: GoalStatus, result: bytes | None = None, text: str = ''
    ) -> None:
        """Answer a get_result request. `text` is appended to the result, for clients that run on goalwire."""
        payload = wire.with_status(result or self.default(), status)
        request.reply(wire.with_reason(payload, text) if text else payload)

    # -- kept ----------------------------------------------------------------------------------------------

    def keep(self, ended: KeepResult[Request, bytes]) -> None:
        """Write the end of a goal into the journal, then answer the requests for its result."""
        assert self.journal is not None
        written = self.journal.end(ended.goal_id, ended.status, ended.result)
        written.add_done_callback(partial(self._answer_all, ended))

    def _answer_all(self, ended: KeepResult[Request, bytes], written: Future[None]) -> None:
        error = written.exception()
        if error is not None:  # the goal has ended all the same: its waiting clients get the result
            self._logger.error(
                f"Action '{self._name}': the end of a goal is not in the journal: {error}; "
                'after a restart it counts as begun and not ended'
            )
        for request in ended.requests:
            self._try_to_reply(request, ended.status, ended.result)

    def find(self, asked: FindResult[Request]) -> None:
        """Answer, from the journal, a request for the result of a goal that is not running."""
        assert self.journal is not None
        found = self.journal.find(asked.goal_id)
        found.add_done_callback(partial(self._tell, asked.request))

    def _tell(self, request: Request, found: Future[KnownGoal | None]) -> None:
        assert self.journal is not None
        error = found.exception()
        if error is not None:  # do not answer: after UNKNOWN the client might send the goal again
            self._logger.error(f"Action '{self._name}': a request for a result has no answer: {error}")
            return
        goal = found.result()
        if goal is None:
            self._try_to_reply(request, GoalStatus.UNKNOWN, None, absence_text(self.journal.uuid))
        elif goal.server_died:
            self._try_to_reply(request, goal.status, None, SERVER_DIED)
        elif goal.result is None and goal.status.is_terminal:
            self._try_to_reply(request, goal.status, None, RESULT_DROPPED)
        else:
            self._try_to_reply(request, goal.status, goal.result)

    def _try_to_reply(
        self, request: Request, status: GoalStatus, result: bytes | None, text: str = ''
    ) -> None:
        try:
            self.reply(request, status, result, text)
        except ClosedError:
            return  # the context has ended: nothing can be sent
        except TransportError as error:
            self._logger.error(f"Action '{self._name}': a client was not told of a result: {error}")

    def warn_known(self, goal_id: GoalId) -> None:
        """Log that a goal is refused since the journal has its id."""
        self._logger.warning(
            f"Action '{self._name}': goal {goal_id.hex()} was accepted before, and is not executed again"
        )

    def log_refusal(self, error: JournalError) -> None:
        """Log that a goal is refused since it cannot be written."""
        self._logger.error(f"Action '{self._name}': a goal is refused, since the journal failed: {error}")

    def close(self) -> None:
        """Finish the queued writes, and close the journal. Idempotent."""
        if self.journal is not None:
            self.journal.close()
