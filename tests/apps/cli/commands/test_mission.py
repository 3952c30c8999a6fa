"""goalwire mission: what it shows of a journal, and the commands that it leaves in it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from goalwire.apps.cli.main import run_command
from goalwire.missions.file_lock import FileLock, lock_path
from goalwire.missions.journal_store import Change, MissionRow, Store
from goalwire.rules.missions.entries import Entry, EntryKind, Json, MissionState

CODE = """
from goalwire.missions import mission

@mission(version=2)
async def tour(m, *places):
    await m.run(len, places)
    await m.approve('go home?')

@mission()
async def other(m):
    await m.sleep(1.0)
"""
DRIVE: dict[str, Json] = {'kind': 'goal', 'target': 'drive', 'digest': 'd'}


class Journal:
    """A journal with a mission in each state, and the command line on it."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.file = folder / 'missions.db'
        self.code = folder / 'code.py'
        self.code.write_text(CODE, encoding='utf-8')
        self._capsys = capsys
        with Store(self.file) as store:
            for number, state in enumerate(MissionState):
                id_ = state.replace(' ', '-')
                store.add(
                    MissionRow(id_, 'tour', 1, 'f', (number,), MissionState.RUNNING, '', number, number)
                )
                entries = [Entry(EntryKind.INTENT, 0, {**DRIVE, 'goal_id': 'ab' * 16}, b'', 1.0)]
                if state in {MissionState.LOST, MissionState.APPROVAL}:
                    entries.append(Entry(EntryKind.ASKED, 0, {'question': 'well?'}, b'', 2.0))
                store.commit([Change(id_, tuple(entries), state, 'for a reason')], 3.0)

    def run(self, *arguments: str, code: int = 0) -> list[str]:
        """Run `goalwire mission` and return the lines it printed; if it fails, the one it complained by."""
        verb, *rest = arguments
        assert run_command('goalwire', ['mission', verb, '-j', str(self.file), *rest]) == code
        captured = self._capsys.readouterr()
        return (captured.err if code else captured.out).splitlines()

    def commands(self) -> list[tuple[str, str, dict[str, Json]]]:
        """Return what waits for the runner."""
        with Store(self.file) as store:
            return [(each.mission, each.verb, dict(each.body)) for each in store.commands()]


@pytest.fixture
def journal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Journal:
    return Journal(tmp_path, capsys)


def test_missions_are_listed_with_what_they_wait_for(journal: Journal) -> None:
    lines = journal.run('list')
    assert [line.split()[0] for line in lines] == [state.replace(' ', '-') for state in MissionState]
    assert all('tour  since 1970-01-01' in line and line.endswith('for a reason') for line in lines)
    assert len(journal.run('list', '--open')) == 7
    found = [json.loads(line) for line in journal.run('list', '--json')]
    assert found[0] == {
        'id': 'running', 'name': 'tour', 'version': 1, 'arguments': [0], 'state': 'running',
        'why': 'for a reason', 'begun': 0.0, 'changed': 3.0, 'result': None, 'has_runner': False,
    }  # fmt: skip


def test_open_missions_that_nobody_runs_are_marked(journal: Journal) -> None:
    def marked() -> set[str]:
        return {line.split()[0] for line in journal.run('list') if '; nobody runs it  for a' in line}

    everything = {state.replace(' ', '-') for state in MissionState if state.is_open}
    told = 'Runner: none; the mission goes on when its runner is started'
    assert marked() == everything
    assert told in journal.run('show', 'running')
    assert told not in journal.run('show', 'succeeded')
    lock = FileLock(lock_path(journal.file))
    try:
        assert not marked()
        assert told not in journal.run('show', 'running')
        assert json.loads(journal.run('show', 'running', '--json')[0])['has_runner'] is True
    finally:
        lock.close()
    assert marked() == everything


@pytest.mark.parametrize(
    ('mission', 'following'),
    [
        ('lost', 'look at the robot, then: goalwire mission decide lost-step done|again|fail'),
        ('appr', 'goalwire mission approve approval yes|no'),
        ('held', 'look at the robot, then: goalwire mission resume held'),
        ('stuck', 'run the code that fits, or: goalwire mission cancel stuck'),
    ],
)
def test_show_says_how_to_answer(journal: Journal, mission: str, following: str) -> None:
    lines = journal.run('show', mission)
    assert lines[-1] == f'Next: {following}'
    assert 'Why: for a reason' in lines


def test_history_has_a_line_for_each_entry(journal: Journal) -> None:
    lines = [line.split('  ', 1)[1] for line in journal.run('history', 'lost')]
    assert lines == [f'step 1: goal drive begins, goal {"ab" * 16}', 'step 1: asks: well?']
    found = json.loads(journal.run('history', 'lost', '--json')[0])
    assert (found['entry'], found['step'], found['goal_id']) == ('intent', 1, 'ab' * 16)


def test_history_names_who_has_answered(journal: Journal) -> None:
    with Store(journal.file) as store:
        answer = Entry(EntryKind.ANSWERED, 0, {'answer': 'yes', 'who': 'ann'}, b'', 4.0)
        store.commit([Change('approval', (answer,))], 4.0)
    assert journal.run('history', 'approval')[-1].endswith('step 1: answer: yes, by ann')


def test_commands_wait_in_the_journal_for_the_runner(journal: Journal) -> None:
    journal.run('decide', 'lost', 'again')
    journal.run('approve', 'approval', 'no')
    journal.run('pause', 'running')
    journal.run('resume', 'held')
    journal.run('cancel', 'stuck', '--no-undo')
    assert journal.commands() == [
        ('lost-step', 'decide', {'step': 0, 'answer': 'again'}),
        ('approval', 'approve', {'step': 0, 'answer': 'no'}),
        ('running', 'pause', {}),
        ('held', 'resume', {}),
        ('stuck', 'cancel', {'undo': False}),
    ]


def test_what_cannot_be_is_said_in_one_line(journal: Journal, tmp_path: Path) -> None:
    for arguments, code, told in [
        (('approve', 'lost'), 7, 'asks no such question: it is lost step; see: goalwire mission show'),
        (('cancel', 'succeeded'), 7, "mission 'succeeded' has ended: succeeded"),
        (('show', 'sucseeded'), 3, "there is no mission 'sucseeded'; did you mean 'succeeded'?"),
        (('show', 's'), 4, "2 missions begin with 's'"),
        (('run', 'nowhere.py:tour'), 3, "there is no file 'nowhere.py'"),
        (('run', 'tour'), 2, 'write FILE:NAME'),
        (('run', f'{journal.code}:tuor'), 3, 'it has: other, tour'),
    ]:
        (line,) = journal.run(*arguments, code=code)
        assert told in line
    journal.file = tmp_path / 'nowhere.db'
    assert 'there is no journal' in journal.run('list', code=3)[0]
    journal.file = journal.code
    assert 'not a database' in journal.run('list', code=10)[0]
    assert journal.code.read_text(encoding='utf-8') == CODE


def test_code_is_checked_against_the_open_missions(journal: Journal) -> None:
    (line,) = journal.run('check', str(journal.code), code=1)
    assert '7 open missions do not fit this code' in line
    for state in MissionState:
        if state.is_open and state is not MissionState.RUNNING:
            journal.run('cancel', state.replace(' ', '-'))
    with Store(journal.file) as store:
        store.commit([Change('running', (), MissionState.SUCCEEDED)], 4.0)
        for state in MissionState:
            store.commit([Change(state.replace(' ', '-'), (), MissionState.CANCELED)], 4.0)
        store.add(MissionRow('new', 'tour', 2, 'f', (1, 2), MissionState.RUNNING, '', 9.0, 9.0))
    assert journal.run('check', str(journal.code)) == ['new: fits']
