"""The answers of a scripted service, one for each call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, Final, Generic, TypeAlias, TypeVar

from goalwire.records import record

ResponseT = TypeVar('ResponseT')


class _Never(Enum):
    NEVER = 'never'


NEVER: Final = _Never.NEVER
"""An answer in a script: no answer comes as long as the service exists."""


@record
class After(Generic[ResponseT]):
    """An answer that comes after a delay."""

    seconds: float
    answer: Answer[ResponseT]


def after(seconds: float, answer: Answer[ResponseT] = None) -> After[ResponseT]:
    """Return an entry of a script: it gives `answer`, which may be any entry of a script, after a delay."""
    return After(seconds, answer)


Answer: TypeAlias = 'ResponseT | BaseException | type[BaseException] | Callable[[Any], Any] | After[ResponseT] | _Never | None'  # fmt: skip # noqa: E501
Answers: TypeAlias = 'Answer[ResponseT] | Sequence[Answer[ResponseT]]'


class Script(Generic[ResponseT]):
    """The answers of a service: one for all calls, or a list with one for each call. Raises TypeError for
    other values.
    """

    def __init__(self, answers: Answers[ResponseT], response: type[ResponseT]) -> None:
        self._answers = list(answers) if isinstance(answers, Sequence) else None
        self._same = None if isinstance(answers, Sequence) else answers
        self._given = 0
        for answer in [self._same] if self._answers is None else self._answers:
            _check(answer, response)

    def next(self) -> Answer[ResponseT]:
        """Return the next answer. Raises AssertionError if the script has no further answer."""
        self._given += 1
        if self._answers is None:
            return self._same
        if self._given > len(self._answers):
            raise AssertionError(f'call {self._given} came, and there are {len(self._answers)} answers')
        answer: Answer[ResponseT] = self._answers[self._given - 1]
        return answer


def _check(answer: object, response: type) -> None:
    while isinstance(answer, After):
        answer = answer.answer
    is_told = isinstance(answer, (response, BaseException)) or answer is None or answer is NEVER
    if not (is_told or callable(answer)):
        raise TypeError(
            f'an answer is a {response.__name__}, a function, an exception, NEVER or after(…), not {answer!r}'
        )
