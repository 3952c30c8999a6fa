"""The progress of a goal, read from one field of its feedback: FIELD, or FIELD/MAX."""

from __future__ import annotations

from typing import Any

from goalwire.errors import with_advice

_RISING = frozenset({'fraction', 'progress', 'completion', 'ratio'})
_PERCENT = frozenset({'percent', 'percentage'})
_NUMBERS = ('float', 'double', 'int', 'uint')


class ProgressError(ValueError):
    """The feedback has no number in the field for the progress, or MAX is not a number above 0."""

    def __init__(self, problem: str, advice: str = '') -> None:
        super().__init__(with_advice(problem, advice))


class Progress:
    """Reads one field of the feedback of one goal.

    The value of a field that counts down, such as `distance_remaining`, is compared with its first value. If
    that value was missed, because the goal already ran when the first feedback was received, the progress is
    unknown.
    """

    def __init__(self, spec: str, *, saw_start: bool = True) -> None:
        """Take `spec` as FIELD or FIELD/MAX, and whether the goal's first feedback was seen.

        Raises ProgressError if MAX is not a number above 0.
        """
        self._saw_start = saw_start
        path, slash, most = spec.partition('/')
        self._path = path.split('.')
        self._falls = any(_tells_what_remains(part) for part in self._path)
        self._first: float | None = None
        try:
            self._most = float(most) if slash else 1.0
        except ValueError:
            self._most = 0.0
        if not self._most > 0:
            raise ProgressError(
                f"--progress {spec}: '{most}' is not a number above 0", 'write FIELD or FIELD/MAX'
            )

    def read(self, feedback: Any) -> float | None:
        """Return the progress, 0 to 1; None if the first value of a field that counts down was missed.

        Raises ProgressError if the feedback has no such field, or the field is not a number.
        """
        number = self._number(feedback)
        if self._first is None:
            self._first = number
        if not self._falls:
            return _limit(number / self._most)
        if not self._saw_start:
            return None
        return _limit(1 - number / self._first) if self._first > 0 else 1.0

    def _number(self, feedback: Any) -> float:
        value, path = feedback, '.'.join(self._path)
        for part in self._path:
            known: dict[str, str] = getattr(value, 'get_fields_and_field_types', dict)()
            if not known or not hasattr(value, part):
                advice = f'its fields are: {", ".join(known)}' if known else ''
                raise ProgressError(f"the feedback has no field '{path}'", advice)
            value = getattr(value, part)
        is_sequence = hasattr(value, '__len__') and not isinstance(value, str)
        try:
            return float(len(value) if is_sequence else value)
        except (TypeError, ValueError):
            raise ProgressError(f"the field '{path}' is not a number", 'name another one') from None


def likely_field(feedback: Any) -> str | None:
    """Return the field whose name suggests progress, in the form that `Progress` takes, or None.

    A field that counts up is preferred to a field that counts down.
    """
    fields: dict[str, str] = feedback.get_fields_and_field_types()
    numbers = [name for name, kind in fields.items() if kind.startswith(_NUMBERS) and '[' not in kind]
    for name in numbers:
        if not _RISING.isdisjoint(name.split('_')):
            return name
    for name in numbers:
        if not _PERCENT.isdisjoint(name.split('_')):
            return f'{name}/100'
    return next(filter(_tells_what_remains, numbers), None)


def _tells_what_remains(name: str) -> bool:
    return 'remaining' in name or name.endswith(('_left', 'to_go'))


def _limit(number: float) -> float:
    """Limit a number to the range from 0 to 1; NaN, which a peer may send, becomes 0."""
    return min(max(number, 0.0), 1.0) if number == number else 0.0  # noqa: PLR0124
