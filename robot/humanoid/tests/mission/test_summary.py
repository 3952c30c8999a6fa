from __future__ import annotations

import re

import pytest

from humanoid.mission.events import Began, Finished, Progressed
from humanoid.mission.summary import Summary

FIRST, SECOND = Began(1, 2, 'raise the arm', 'SUCCEEDED'), Began(2, 2, 'drive', 'refused')


def state(summary: Summary) -> tuple[bool, bool]:
    return summary.complete, summary.all_well


def test_all_is_well_once_every_step_ended_as_it_should() -> None:
    summary = Summary()
    summary.note(FIRST)
    summary.note(Finished(1, ok=True, happened='SUCCEEDED', seconds=1.0))
    assert state(summary) == (False, False)
    summary.note(SECOND)
    summary.note(Progressed(2, 0.5, 'on the way'))
    assert state(summary) == (False, False)
    summary.note(Finished(2, ok=True, happened='refused', seconds=0.5))
    assert state(summary) == (True, True)


def test_one_failed_step_spoils_it() -> None:
    summary = Summary()
    for event in (FIRST, Finished(1, ok=False, happened='ABORTED', seconds=1.0)):
        summary.note(event)
    for event in (SECOND, Finished(2, ok=True, happened='refused', seconds=0.5)):
        summary.note(event)
    assert state(summary) == (True, False)


def test_nothing_heard_is_not_well() -> None:
    assert not Summary().all_well
    assert '0 of ? steps' in Summary().table()


@pytest.mark.parametrize('width', [60, 80, 120])
def test_the_table_is_no_wider_than_the_terminal(monkeypatch: pytest.MonkeyPatch, width: int) -> None:
    monkeypatch.setenv('COLUMNS', str(width))
    summary = Summary()
    summary.note(Began(1, 1, 'newer goal while driving', 'older ABORTED, newer SUCCEEDED'))
    happened = 'older ABORTED (Pre-empted by a newer goal), newer SUCCEEDED'
    summary.note(Finished(1, ok=True, happened=happened, seconds=1.0))
    *rows, _ = summary.table().splitlines()
    assert max(map(len, rows)) <= width
    assert set(happened.split()) <= set(' '.join(rows).split()), 'words were lost'


def test_the_table_says_step_expected_happened_and_time() -> None:
    summary = Summary()
    summary.note(FIRST)
    summary.note(Finished(1, ok=False, happened='ABORTED: late', seconds=1.25))
    summary.note(SECOND)
    head, _, first, second, last = summary.table().splitlines()
    assert head.split() == ['step', 'expected', 'happened', 'time']
    cells = ['FAILED', 'raise the arm', 'SUCCEEDED', 'ABORTED: late', '1.2 s']
    assert re.split(' {2,}', first) == cells
    assert second.startswith('cut')
    assert 'it did not end' in second
    assert last == '0 of 2 steps ended as they should, in 1.2 s'
