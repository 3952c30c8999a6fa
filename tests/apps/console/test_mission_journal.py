"""The journal of missions as the console commands it: what its visitor may not say is not in the file."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from goalwire.apps.console.settings import Settings
from goalwire.apps.console.state.mission_journal import MissionJournal
from goalwire.apps.console.state.rights import Rights
from goalwire.errors import MissionError, NotAllowedError
from goalwire.logging import get_logger
from goalwire.missions.journal_store import Change, MissionRow, Store
from goalwire.rules.missions.entries import Entry, EntryKind, MissionState
from goalwire.security import audit
from goalwire.security.environment import Chosen
from goalwire.security.revocation import write_revoked
from goalwire.security.sign_in.authorizer import Authorizer
from goalwire.security.sign_in.signed_in import SignedIn
from goalwire.security.sign_in.tokens import make_token

POLICY = """\
[roles.operator]
missions = true
[roles.guest]
[roles.locked]
stop = false
[identities]
console = ["operator"]
ann = ["operator"]
ben = ["guest"]
cy = ["operator", "locked"]
"""


@pytest.fixture
def keystore(tmp_path: Path) -> Path:
    """A keystore without keys: who asks the policy needs none."""
    folder = tmp_path / 'keys'
    folder.mkdir()
    (folder / 'policy.toml').write_text(POLICY)
    (folder / 'revoked.toml').write_text(write_revoked({}))
    return folder


@pytest.fixture
def authorizer(keystore: Path) -> Iterator[Authorizer]:
    with closing(Authorizer(Chosen(keystore, 'console'))) as made:
        yield made


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    """Missions that wait: `held` for somebody who resumes it, `asks` for an approval."""
    path = tmp_path / 'missions.db'
    with Store(path) as store:
        for id_, state in (('held', MissionState.HELD), ('asks', MissionState.APPROVAL)):
            asked = Entry(EntryKind.ASKED, 2, {'question': 'carry 7 kg?'})
            store.add(MissionRow(id_, 'rounds', 1, '', (), state, '', 0.0, 0.0), asked)
    return path


def visitor(authorizer: Authorizer, name: str, settings: Settings | None = None) -> Rights:
    token = make_token(authorizer.identity.folder, name)
    signed_in = SignedIn(authorizer, authorizer.find_principal(token))
    return Rights(settings or Settings(), get_logger('console'), signed_in)


def seen(journal: Path, mission: str) -> MissionRow:
    with Store(journal, must_exist=True) as store:
        row = store.mission(mission)
    assert row is not None
    return row


def say(journal: Path, mission: str, word: str, by: Rights) -> None:
    asyncio.run(MissionJournal(str(journal)).say(seen(journal, mission), word, by))


def commands(journal: Path) -> list[tuple[str, str, object]]:
    with Store(journal, must_exist=True) as store:
        return [(each.mission, each.verb, each.body) for each in store.commands()]


def test_whoever_has_the_right_answers_resumes_and_undoes(journal: Path, authorizer: Authorizer) -> None:
    ann = visitor(authorizer, 'ann')
    say(journal, 'asks', 'yes', ann)
    say(journal, 'held', 'resume', ann)
    say(journal, 'held', 'undo', ann)
    assert commands(journal) == [
        ('asks', 'approve', {'step': 2, 'answer': 'yes', 'who': 'ann'}),
        ('held', 'resume', {'who': 'ann'}),
        ('held', 'cancel', {'undo': True, 'who': 'ann'}),
    ]


@pytest.mark.parametrize(
    ('mission', 'word', 'verb', 'what'),
    [('asks', 'yes', 'approve', 'yes'), ('held', 'resume', 'resume', ''), ('held', 'undo', 'cancel', 'undo')],
)
def test_without_the_right_nothing_is_in_the_journal_but_a_line_in_the_log(
    journal: Path, authorizer: Authorizer, mission: str, word: str, verb: str, what: str
) -> None:
    ben = visitor(authorizer, 'ben')
    with pytest.raises(NotAllowedError, match="none of the roles of 'ben' has missions = true: nothing was"):
        say(journal, mission, word, ben)
    assert commands(journal) == []
    authorizer.close()
    (entry,) = audit.read(audit.log_path(authorizer.identity.folder, 'console'))
    assert (entry['outcome'], entry['act'], entry.get('what', '')) == ('was refused', verb, what)
    assert entry['key'] == f'mission rounds {mission}'


def test_to_cancel_without_undo_is_for_everybody_who_may_stop(journal: Path, authorizer: Authorizer) -> None:
    with pytest.raises(NotAllowedError, match='locked: stop = false: nothing was stopped'):
        say(journal, 'held', 'cancel', visitor(authorizer, 'cy'))
    say(journal, 'held', 'cancel', visitor(authorizer, 'ben'))
    assert commands(journal) == [('held', 'cancel', {'undo': False, 'who': 'ben'})]


def test_the_options_of_the_console_count_for_everybody(journal: Path, authorizer: Authorizer) -> None:
    for settings in (Settings(read_only=True), Settings(allow=('other',))):
        with pytest.raises(NotAllowedError, match='nothing was sent'):
            say(journal, 'held', 'resume', visitor(authorizer, 'ann', settings))
        with pytest.raises(NotAllowedError, match='nothing was sent'):
            say(journal, 'held', 'resume', Rights(settings, get_logger('console')))
    assert commands(journal) == []


def test_a_mission_takes_only_what_it_waits_for(journal: Path, authorizer: Authorizer) -> None:
    for mission, word in (('asks', 'resume'), ('held', 'yes')):
        with pytest.raises(MissionError, match=f"mission '{mission}' does not wait for that any more"):
            say(journal, mission, word, visitor(authorizer, 'ann'))
    assert commands(journal) == []


def test_an_answer_to_one_question_is_not_taken_for_the_next_one(
    journal: Path, authorizer: Authorizer
) -> None:
    """Somebody else answers while a visitor reads, and the mission asks for more, in the same words."""
    read = seen(journal, 'asks')
    with Store(journal, must_exist=True) as store:
        answered = Entry(EntryKind.ANSWERED, 2, {'answer': 'yes'})
        asked = Entry(EntryKind.ASKED, 3, {'question': 'carry 7 kg?'})
        store.commit([Change('asks', (answered, asked), MissionState.APPROVAL, read.why)], 5.0)
    with pytest.raises(MissionError, match="mission 'asks' does not wait for that any more"):
        asyncio.run(MissionJournal(str(journal)).say(read, 'yes', visitor(authorizer, 'ann')))
    assert commands(journal) == []
