"""Replays a mission: its code runs again, and each step that is in the journal returns its recorded outcome.

A mission does its steps one after the other, so a step's number identifies the step. The code has to request
the same steps in the same order, with the same arguments. If the code requests another step, it was changed,
or it depends on data outside the journal, such as the time. Then goalwire guesses nothing: the mission is
stuck until a person has looked at it.
"""

from __future__ import annotations

from collections.abc import Iterable

from goalwire.records import record
from goalwire.rules.missions.entries import Entry, EntryKind, StepKey


class DoesNotFit(BaseException):
    """An error if a mission's code does not fit its journal; the text names the step, and what each side has.

    The class does not derive from Exception, so a mission's `except Exception` does not catch it as a failed
    step.
    """


@record
class StepHistory:
    """The entries of one step in the journal."""

    number: int
    """The number of the step, counted from 0."""
    key: StepKey
    entries: tuple[Entry, ...]

    @property
    def intent(self) -> Entry | None:
        """The newest intent. A step that was sent again has several intents."""
        intents = [entry for entry in self.entries if entry.kind is EntryKind.INTENT]
        return intents[-1] if intents else None

    @property
    def ended(self) -> Entry | None:
        """The entry for the end of the step; None while the step is open."""
        return next((entry for entry in self.entries if entry.kind is EntryKind.ENDED), None)

    def since_intent(self, kind: EntryKind) -> Entry | None:
        """Return the newest entry of a kind after the newest intent; None if there is no such entry."""
        for entry in reversed(self.entries):
            if entry.kind is kind:
                return entry
            if entry.kind is EntryKind.INTENT:
                break
        return None

    @property
    def attempts(self) -> int:
        """The number of intents."""
        return sum(entry.kind is EntryKind.INTENT for entry in self.entries)


class Replay:
    """A position in a journal. Each step that the mission's code requests moves the position forward."""

    def __init__(self, entries: Iterable[Entry]) -> None:
        self._steps: dict[int, list[Entry]] = {}
        for entry in entries:
            if entry.step >= 0:
                self._steps.setdefault(entry.step, []).append(entry)
        self._next = 0

    @property
    def is_over(self) -> bool:
        """True if the journal has no outcome of the next step: now steps are carried out, not replayed."""
        recorded = self._steps.get(self._next)
        return recorded is None or not any(entry.kind is EntryKind.ENDED for entry in recorded)

    def begin(self, key: StepKey) -> StepHistory:
        """Return the journal's entries of the step that the code requests now. Raises DoesNotFit."""
        number = self._next
        recorded = tuple(self._steps.get(number, ()))
        if recorded:
            check_key(number, _key_of(recorded[0]), key)
        self._next += 1
        return StepHistory(number, key, recorded)

    def finish(self) -> None:
        """Check the journal when the code has ended. Raises DoesNotFit if the journal has further steps."""
        if self._next in self._steps:
            left = _key_of(self._steps[self._next][0])
            raise DoesNotFit(f'step {self._next + 1} was {left}, and the code ends before it')


def check_key(number: int, recorded: StepKey, asked: StepKey) -> None:
    """Raise DoesNotFit unless the step that the code requests is the one in the journal."""
    if recorded == asked:
        return
    step = f'step {number + 1}'
    if (recorded.kind, recorded.target) == (asked.kind, asked.target):
        raise DoesNotFit(
            f'{step}, {recorded}, has other arguments than in the journal: they were changed, or they '
            'depend on something that is not a step, such as the time (use m.now(), m.random())'
        )
    raise DoesNotFit(f'{step} was {recorded}, and the code asks for {asked}')


def _key_of(entry: Entry) -> StepKey:
    body = entry.body
    return StepKey(str(body.get('kind', '')), str(body.get('target', '')), str(body.get('digest', '')))
