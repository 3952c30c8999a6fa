"""How far a goal is, as a field of its feedback tells: `--progress FIELD` or `--progress FIELD/MAX`."""

from __future__ import annotations

from typing import Any

from goalwire.apps.cli.framework.outcome import CommandError, Outcome

HELP = (
    'Draw a bar on a terminal from a field of the feedback: a part of 1, or of MAX as in FIELD/MAX; of an '
    'array its length counts. A field that says what remains begins at nothing done'
)
_FALLING = ('remaining', 'left', 'to_go')
_NUMBERS = ('float', 'double', 'int', 'uint')
_WIDTH = 30


class Progress:
    """Reads one field of the feedback of one goal.

    A field that says what remains is measured by its first value. Who has not seen that, because the goal ran
    before, cannot tell how much is done: `saw_start` is False then. So all who tell a figure tell the same.
    """

    def __init__(self, spec: str, *, saw_start: bool = True) -> None:
        """Raises CommandError."""
        self._saw_start = saw_start
        path, slash, most = spec.partition('/')
        self._path = path.split('.')
        self._falls = any(word in path for word in _FALLING)
        self._first: float | None = None
        try:
            self._most = float(most) if slash else 1.0
        except ValueError:
            self._most = 0.0
        if not self._most > 0:
            raise CommandError(
                Outcome.BAD_VALUE,
                f"--progress {spec}: '{most}' is no number above 0",
                'write FIELD or FIELD/MAX',
            )

    def of(self, feedback: Any) -> float | None:
        """Return how much is done, 0 to 1, None if nobody here can tell.

        Raises CommandError where there is no such number.
        """
        value = feedback
        for part in self._path:
            if not hasattr(value, 'get_fields_and_field_types') or not hasattr(value, part):
                known: dict[str, str] = getattr(value, 'get_fields_and_field_types', dict)()
                raise CommandError(
                    Outcome.BAD_VALUE,
                    f"the feedback has no field '{'.'.join(self._path)}'",
                    f'its fields are: {", ".join(known)}' if known else '',
                )
            value = getattr(value, part)
        try:
            number = float(len(value) if hasattr(value, '__len__') and not isinstance(value, str) else value)
        except (TypeError, ValueError):
            raise CommandError(
                Outcome.BAD_VALUE, f"the field '{'.'.join(self._path)}' is no number", 'name another one'
            ) from None
        if self._first is None:
            self._first = number
        if self._falls:
            if not self._saw_start:
                return None
            return _bounded(1 - number / self._first) if self._first > 0 else 1.0
        return _bounded(number / self._most)


def likely_field(feedback: Any) -> str | None:
    """Return the field that by its name tells how far a goal is, as `--progress` takes it; None for none."""
    fields: dict[str, str] = feedback.get_fields_and_field_types()
    numbers = [name for name, kind in fields.items() if kind.startswith(_NUMBERS) and '[' not in kind]
    for words, most in ((('fraction', 'progress'), ''), (('percent',), '/100'), (_FALLING, '')):
        for name in numbers:
            if any(word in name for word in words):
                return name + most
    return None


def bar(done: float) -> str:
    """Return a bar for a terminal."""
    full = round(done * _WIDTH)
    return f'{"█" * full}{"░" * (_WIDTH - full)} {done * 100:3.0f} %'


def _bounded(number: float) -> float:
    """Return a number from 0 to 1; 0 for one that is none, as a peer may send it."""
    return min(max(number, 0.0), 1.0) if number == number else 0.0  # noqa: PLR0124
