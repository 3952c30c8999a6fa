"""Replaying a journal: steps that are recorded answer, and code that asks for others does not fit."""

from __future__ import annotations

import pytest

from goalwire.rules.missions.entries import Entry, EntryKind, StepKey, digest_of, goal_id_of
from goalwire.rules.missions.holding import Sighting, why_held
from goalwire.rules.missions.replay import DoesNotFit, Replay

KEYS = [StepKey('goal', 'drive', str(number)) for number in range(4)]


def journal(*keys: StepKey, last_is_open: bool = False) -> list[Entry]:
    """A journal in which these steps were carried out."""
    entries = []
    for number, key in enumerate(keys):
        entries.append(Entry(EntryKind.INTENT, number, key.facts))
        if not (last_is_open and number == len(keys) - 1):
            entries.append(Entry(EntryKind.ENDED, number, {**key.facts, 'value': number}))
    return entries


def run(entries: list[Entry], asked: list[StepKey]) -> int:
    """Replay code that asks for these steps, to its end; return how many answered. Raises DoesNotFit."""
    replay = Replay(entries)
    answered = sum(replay.begin(key).ended is not None for key in asked)
    replay.finish()
    return answered


def test_steps_answer_until_the_journal_is_over() -> None:
    assert run(journal(*KEYS), KEYS) == 4
    assert run(journal(*KEYS[:2]), KEYS) == 2
    assert run(journal(*KEYS[:2], last_is_open=True), KEYS) == 1
    assert run([], KEYS) == 0


def mutations() -> list[tuple[list[StepKey], int]]:
    """Changed programs, and the first step of each that is another one than before."""
    new = StepKey('call', 'tare', '')
    other = StepKey('goal', 'drive', 'other')
    made: list[tuple[list[StepKey], int]] = []
    for at in range(4):
        made += [
            ([*KEYS[:at], new, *KEYS[at:]], at),  # inserted
            ([*KEYS[:at], *KEYS[at + 1 :]], at),  # removed
            ([*KEYS[:at], other, *KEYS[at + 1 :]], at),  # other arguments
            ([*KEYS[:at], StepKey('goal', 'fly', str(at)), *KEYS[at + 1 :]], at),  # renamed
            ([*KEYS[:at]], at),  # ends before it
        ]
        for to in range(at + 1, 4):
            swapped = list(KEYS)
            swapped[at], swapped[to] = swapped[to], swapped[at]
            made.append((swapped, at))
    return made


@pytest.mark.parametrize('recorded', [1, 2, 4])
def test_mutated_code_is_stuck_at_the_step_that_differs_or_goes_on(recorded: int) -> None:
    for program, differs_at in mutations():
        if differs_at >= recorded:
            assert run(journal(*KEYS[:recorded]), program) == recorded
        else:
            with pytest.raises(DoesNotFit, match=f'^step {differs_at + 1}[ ,]'):
                run(journal(*KEYS[:recorded]), program)


def test_a_step_that_was_sent_again_is_known_by_its_newest_intent() -> None:
    key = KEYS[0]
    entries = [
        Entry(EntryKind.INTENT, 0, {**key.facts, 'attempt': 1}),
        Entry(EntryKind.ASKED, 0, {'question': '?'}),
        Entry(EntryKind.ANSWERED, 0, {'answer': 'again'}),
        Entry(EntryKind.INTENT, 0, {**key.facts, 'attempt': 2}),
    ]
    history = Replay(entries).begin(key)
    assert history.intent is entries[3]
    assert history.attempts == 2
    assert history.since_intent(EntryKind.ANSWERED) is None  # that answer was about the first one
    first = Replay(entries[:3]).begin(key)
    assert first.since_intent(EntryKind.ANSWERED) is entries[2]


def test_ids_and_digests_are_the_same_each_time_and_no_other_ones() -> None:
    file = 'e7f2a1de-9dad-41d1-80b4-00c04fd430c8'
    ids = {
        goal_id_of(uuid, mission, step, attempt)
        for uuid in (file, '00000000-9dad-41d1-80b4-00c04fd430c8')
        for mission in ('a', 'b')
        for step in (0, 1)
        for attempt in (1, 2)
    }
    assert len(ids) == 16
    assert goal_id_of(file, 'a', 0, 1) in ids
    assert digest_of('ab', b'c') == digest_of('ab', 'c') != digest_of('a', 'bc')


def test_a_restart_holds_unless_it_was_short_or_the_mission_says_otherwise() -> None:
    now = Sighting('boot', 100.0)
    assert why_held('ask', Sighting('boot', 50.0), now) == ''
    assert why_held('ask', Sighting('boot', 30.0), now) == 'the runner was away for 70 s'
    assert why_held('ask', Sighting('earlier', 99.0), now) == 'the machine was restarted'
    assert why_held('ask', None, now) == 'the machine was restarted'
    assert why_held('auto', None, now) == ''
