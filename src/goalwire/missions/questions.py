"""The questions that missions ask people, and the answers that they take."""

from __future__ import annotations

from collections.abc import Iterable

from goalwire.errors import MissionError
from goalwire.rules.missions.entries import Decision, Entry, EntryKind, Json, MissionState

ANSWERS = {'decide': tuple(Decision), 'approve': ('yes', 'no')}
"""The allowed answers, by the verb of the command."""


def answer_body(verb: str, answer: str, state: MissionState, entries: Iterable[Entry]) -> dict[str, Json]:
    """Return the body of a command that answers a question.

    Raises MissionError if the mission asks no such question, or the answer is not one of those it takes.
    """
    wanted = MissionState.LOST if verb == 'decide' else MissionState.APPROVAL
    if state is not wanted:
        raise MissionError(f'the mission asks no such question: it is {state}')
    if answer not in ANSWERS[verb]:
        raise MissionError(f"'{answer}' is not an answer: say {', '.join(ANSWERS[verb])}")
    asked = [entry for entry in entries if entry.kind is EntryKind.ASKED]
    return {'step': asked[-1].step, 'answer': answer}


def is_asking(step: Iterable[Entry]) -> bool:
    """Return whether a step's entries end with an unanswered question."""
    is_open = False
    for entry in step:
        is_open = entry.kind is EntryKind.ASKED or (is_open and entry.kind is EntryKind.NOTE)
    return is_open
